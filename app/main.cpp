#include "app/commands/command_line.h"
#include "base/input_error.h"
#include "base/text.h"

#include <csignal>
#include <exception>
#include <iostream>

int main(int argc, char **argv) {
    using namespace springdrive;
    // A limit to the size of files, as of ulimit -f, is an error, as a full disk is.
    std::signal(SIGXFSZ, SIG_IGN);
    try {
        const int status = app::run_command_line(argc, argv);
        if (std::cout.flush()) {
            return status;
        }
        std::cerr << "springdrive: standard output: cannot be written; is its disk full or its "
                     "reader closed?\n";
    } catch (const InputError &error) {
        std::cerr << "springdrive: " << as_utf8(error.what()) << '\n';
    } catch (const std::exception &error) {
        std::cerr << "springdrive: unexpected: " << as_utf8(error.what()) << '\n';
    }
    return 1;
}
