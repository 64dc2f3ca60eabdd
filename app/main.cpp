#include "app/command_line.h"
#include "app/demo.h"
#include "base/input_error.h"

#include <exception>
#include <iostream>
#include <optional>

int main(int argc, char **argv) {
    using namespace springdrive;
    try {
        int exit_status = 0;
        const std::optional<DemoOptions> options = parse_command_line(argc, argv, exit_status);
        if (options) {
            run_demo(*options);
        }
        return exit_status;
    } catch (const InputError &error) {
        std::cerr << "springdrive: " << error.what() << '\n';
    } catch (const std::exception &error) {
        std::cerr << "springdrive: unexpected: " << error.what() << '\n';
    }
    return 1;
}
