// Opens a session, with progress shown on a terminal.
#pragma once

#include "engine/scene/load_progress.h"
#include "engine/session/session.h"

#include <chrono>
#include <condition_variable>
#include <iosfwd>
#include <mutex>
#include <string>
#include <thread>

namespace springdrive::app {

/// Prints "springdrive: big.glb: gathering triangles, 40 %" once per period while it exists, first
/// after one period: faster loading prints nothing.
class LoadLines {
public:
    /// @param progress and `out` must outlive it
    LoadLines(std::string file, const scene::LoadProgress &progress, std::ostream &out,
              std::chrono::milliseconds period = std::chrono::seconds(1));
    ~LoadLines();
    LoadLines(const LoadLines &) = delete;
    LoadLines &operator=(const LoadLines &) = delete;

private:
    void print_each_period();

    std::string file_;
    const scene::LoadProgress &progress_;
    std::ostream &out_;
    std::chrono::milliseconds period_;
    std::mutex mutex_;
    std::condition_variable ended_;
    bool has_ended_ = false;
    std::thread thread_;
};

/// Prints progress lines to standard error while its scene loads, if that takes long.
/// @throw InputError as Session's constructor does
[[nodiscard]] session::Session open_session(const session::SessionOptions &options);

/// Prints each warning once, to standard error.
void print_new_warnings(session::Session &session);

} // namespace springdrive::app
