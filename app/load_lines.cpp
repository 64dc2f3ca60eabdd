#include "app/load_lines.h"

#include "engine/scenario/touch_scene.h"

#include <filesystem>
#include <iostream>
#include <utility>

namespace springdrive {

LoadLines::LoadLines(std::string file, const LoadProgress &progress, std::ostream &out,
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

Scene load_scene_with_lines(const std::string &name, const Workspace &workspace) {
    LoadProgress progress;
    const LoadLines lines(std::filesystem::path(name).filename().string(), progress, std::cerr);
    return touch_scene(name, workspace, &progress);
}

} // namespace springdrive
