#include "client/transport/paced_wire.h"

#include <boost/asio/steady_timer.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace mvw::client {
namespace {

using std::chrono::steady_clock;

constexpr double kPieceSeconds = 0.03;  // of bytes read at a time: often enough to look steady
constexpr double kLeastPiece = 256;

class PacedWire final : public Wire {
 public:
    PacedWire(asio::io_context& io, std::unique_ptr<Wire> wire, PacePtr pace)
        : wire_(std::move(wire)), pace_(std::move(pace)), timer_(io) {}

    asio::awaitable<void> connect(error_code& error) override { return wire_->connect(error); }
    asio::awaitable<void> write(asio::const_buffer bytes, error_code& error) override {
        return wire_->write(bytes, error);
    }
    asio::awaitable<std::size_t> read(asio::mutable_buffer out, error_code& error) override {
        const double rate = pace_->bytes_per_second;
        if (!std::isfinite(rate)) co_return co_await wire_->read(out, error);
        const auto piece = static_cast<std::size_t>(std::max(rate * kPieceSeconds, kLeastPiece));
        const asio::mutable_buffer some = asio::buffer(out, piece);
        const std::size_t n = co_await wire_->read(some, error);
        if (error) co_return n;
        const std::chrono::duration<double> time(static_cast<double>(n) / rate);
        free_at_ = std::max(free_at_, steady_clock::now()) + std::chrono::duration_cast<steady_clock::duration>(time);
        timer_.expires_at(free_at_);
        co_await timer_.async_wait(into(error));
        co_return n;
    }
    void close() override {
        timer_.cancel();
        wire_->close();
    }

 private:
    const std::unique_ptr<Wire> wire_;
    const PacePtr pace_;
    asio::steady_timer timer_;
    steady_clock::time_point free_at_{};
};

}  // namespace

std::unique_ptr<Wire> at_pace(asio::io_context& io, std::unique_ptr<Wire> wire, const PacePtr& pace) {
    if (!pace) return wire;
    return std::make_unique<PacedWire>(io, std::move(wire), pace);
}

}  // namespace mvw::client
