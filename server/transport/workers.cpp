#include "server/transport/workers.h"

#include <pthread.h>
#include <signal.h>

namespace mvw::server {
namespace {

// sendfile() to a peer that has gone raises SIGPIPE, whose default ends the process; its error says the same. Of this
// thread alone: the rest of the process is not ours.
void block_broken_pipes() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

}  // namespace

Workers::Workers(unsigned count) {
    for (unsigned i = 0; i < count; ++i) workers_.push_back(std::make_unique<Worker>());
}

// The first goes last: what the others' connections hold of the server's one listener lives on it.
Workers::~Workers() {
    while (!workers_.empty()) workers_.pop_back();
}

void Workers::start() {
    for (const auto& worker : workers_)
        worker->thread = std::thread([&io = worker->io] {
            block_broken_pipes();
            io.run();
        });
}

void Workers::finish() {
    for (const auto& worker : workers_) worker->more.reset();
}

void Workers::wait() {
    for (const auto& worker : workers_)
        if (worker->thread.joinable()) worker->thread.join();
}

}  // namespace mvw::server
