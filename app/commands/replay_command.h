// `springdrive replay`: a record through the control law again.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

void add_replay_command(CLI::App &app);

} // namespace springdrive::app
