#include "engine/servo/record/file_hash.h"

#include "base/input_error.h"

#include <sha2.h>

#include <array>

namespace springdrive {

std::string sha256_of_file(const std::filesystem::path &file) {
    std::array<char, SHA256_DIGEST_STRING_LENGTH> digits{};
    if (SHA256File(file.c_str(), digits.data()) == nullptr) {
        throw InputError(file.string() + ": cannot be read; check its name and permissions");
    }
    return digits.data();
}

} // namespace springdrive
