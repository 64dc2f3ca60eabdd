#include "app/host/output.h"

#include "base/input_error.h"

#include <fstream>
#include <iostream>
#include <system_error>

namespace springdrive::app {

bool appears_complete(const std::filesystem::path &resolved) {
    std::error_code ignored;
    const std::filesystem::file_type type = std::filesystem::status(resolved, ignored).type();
    return !resolved.string().starts_with("/proc/") &&
           (type == std::filesystem::file_type::regular ||
            type == std::filesystem::file_type::not_found);
}

void write_output(const std::string &where, const Writer &write, FilePolicy policy) {
    if (where == "-") {
        write(std::cout);
        if (!std::cout.flush()) {
            throw InputError("standard output: cannot be written; is its disk full or its reader "
                             "closed?");
        }
        return;
    }
    if (appears_complete(resolved_name(where))) {
        write_file(where, write, policy);
        if (const std::string warning = others_access_text(where);
            policy.readers == Readers::owner && !warning.empty()) { // it replaced one like that
            std::cerr << "springdrive: " << warning << '\n';
        }
        return;
    }
    std::ofstream file(where, std::ios::binary);
    if (!file) {
        throw InputError(where + ": cannot be created; check that its folder exists and its "
                                 "permissions");
    }
    write(file);
    file.close();
    if (!file) {
        throw InputError(where + ": cannot be written completely; is the disk full?");
    }
}

std::string save_as(const std::filesystem::path &file, const Writer &write) {
    const std::string error = error_text_of([&] { write_file(file, write, Existing::keep); });
    return error.empty() ? "saved as " + file.string() : error;
}

} // namespace springdrive::app
