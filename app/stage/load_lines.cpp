#include "app/stage/load_lines.h"

#include <ostream>
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

} // namespace springdrive::app
