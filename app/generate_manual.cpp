// Writes the manual page and the completion for bash, of which the build makes files to install.
#include "app/commands/command_line.h"
#include <CLI/CLI.hpp>

#include <fstream>
#include <iostream>

int main(int argc, char **argv) {
    using namespace springdrive::app;
    if (argc != 3) {
        std::cerr << "usage: generate_manual MANUAL_PAGE COMPLETION\n";
        return 2;
    }
    const auto program = command_tree();
    std::ofstream manual(argv[1], std::ios::binary);
    write_manual(manual, *program);
    manual.close();
    std::ofstream completion(argv[2], std::ios::binary);
    write_bash_completion(completion, *program);
    completion.close();
    if (!manual || !completion) {
        std::cerr << "generate_manual: cannot write " << (manual ? argv[2] : argv[1]) << '\n';
        return 1;
    }
    return 0;
}
