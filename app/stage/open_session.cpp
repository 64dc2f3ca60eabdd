#include "app/stage/open_session.h"

#include "app/stage/load_lines.h"
#include "base/real_time_thread.h"

#include <iostream>
#include <string>

namespace springdrive::app {

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
