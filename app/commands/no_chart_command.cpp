// Replaces chart_command.cpp in builds without charts.
#include "app/commands/command.h"

#include "base/input_error.h"

namespace springdrive::app {

void add_chart_command(Command &app) {
    Command command =
        app.add_subcommand("chart", "speed and accuracy of every method; not in this build");
    command.allow_extras();
    command.callback([] {
        throw InputError(
            "this build has no charts, as CVODE was left out; ./app/run chart installs "
            "it and builds them");
    });
}

} // namespace springdrive::app
