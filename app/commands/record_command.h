// `springdrive record`: a session without a window, recorded at full rate.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

void add_record_command(CLI::App &app);

} // namespace springdrive::app
