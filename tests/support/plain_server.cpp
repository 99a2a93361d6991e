#include "tests/support/plain_server.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>

namespace mvw::test {

namespace asio = boost::asio;
using asio::ip::tcp;

PlainServer::PlainServer(const Bytes& body)
    : answer_("HTTP/1.1 200 OK\r\nContent-Length: " + std::to_string(body.size()) + "\r\nConnection: close\r\n\r\n" +
              std::string(reinterpret_cast<const char*>(body.data()), body.size())),
      acceptor_(io_, {asio::ip::address_v4::loopback(), 0}),
      thread_([this] { run(); }) {}

PlainServer::~PlainServer() {
    stopping_ = true;
    boost::system::error_code ignored;
    tcp::socket(io_).connect(acceptor_.local_endpoint(), ignored);  // wakes accept()
    thread_.join();
}

// One connection after the other; a client that leaves early is no fault.
void PlainServer::run() {
    while (true) {
        boost::system::error_code error;
        tcp::socket socket(io_);
        acceptor_.accept(socket, error);
        if (stopping_) return;
        std::string head;
        asio::read_until(socket, asio::dynamic_buffer(head), "\r\n\r\n", error);
        if (error) continue;
        ++requests_;
        asio::write(socket, asio::buffer(answer_), error);
        socket.shutdown(tcp::socket::shutdown_both, error);
    }
}

}  // namespace mvw::test
