#include "app/stage/open_session.h"

#include "base/real_time_thread.h"

#include <iostream>
#include <ostream>
#include <string>
#include <utility>

namespace springdrive::app {

LoadLines::LoadLines(std::string file, const scene::LoadProgress &progress, std::ostream &out,
                     std::chrono::milliseconds period)
    : file_(std::move(file)), progress_(progress), out_(out), period_(period),
      thread_([this] { print_each_period(); }) {}

LoadLines::~LoadLines() {
    {
        const std::lock_guard lock(mutex_);
        has_ended_ = true;
    }
    ended_.notify_one();
    thread_.join();
}

void LoadLines::print_each_period() {
    std::unique_lock lock(mutex_);
    while (!ended_.wait_for(lock, period_, [this] { return has_ended_; })) {
        out_ << "springdrive: " << file_ << ": " << progress_.text() << std::endl;
    }
}

session::Session open_session(const session::SessionOptions &options) {
    if (!reserve_heaps()) {
        std::cerr << "springdrive: the heap cannot be set up; a board's packets may wait while a "
                     "scene is loaded, and memory may grow in use\n";
    }
    scene::LoadProgress progress;
    const LoadLines lines(options.scene.filename().string(), progress, std::cerr);
    return session::Session(options, &progress); // in place: a session cannot be moved
}

void print_new_warnings(session::Session &session) {
    for (const std::string &warning : session.warnings().take_new()) {
        std::cerr << "springdrive: " << warning << '\n';
    }
}

} // namespace springdrive::app
