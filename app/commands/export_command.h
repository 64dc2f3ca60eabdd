// `springdrive export`: a record for other programs.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

void add_export_command(CLI::App &app);

} // namespace springdrive::app
