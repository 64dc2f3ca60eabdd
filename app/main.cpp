#include "app/commands/command_line.h"
#include "base/input_error.h"

#include <exception>
#include <iostream>

int main(int argc, char **argv) {
    using namespace springdrive;
    try {
        const int status = app::run_command_line(argc, argv);
        if (std::cout.flush()) {
            return status;
        }
        std::cerr << "springdrive: standard output: cannot be written; is its disk full or its "
                     "reader closed?\n";
    } catch (const InputError &error) {
        std::cerr << "springdrive: " << error.what() << '\n';
    } catch (const std::exception &error) {
        std::cerr << "springdrive: unexpected: " << error.what() << '\n';
    }
    return 1;
}
