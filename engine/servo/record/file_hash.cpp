#include "engine/servo/record/file_hash.h"

#include "base/input_error.h"
#include "base/wanted.h"

#include <sha2.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <vector>

namespace springdrive {

std::string sha256_of_file(const std::filesystem::path &file) {
    std::ifstream stream(file, std::ios::binary);
    SHA2_CTX context{};
    SHA256Init(&context);
    std::vector<char> block(std::size_t{1} << 20U);
    while (stream) {
        stop_if_given_up();
        stream.read(block.data(), static_cast<std::streamsize>(block.size()));
        SHA256Update(&context, reinterpret_cast<const std::uint8_t *>(block.data()),
                     static_cast<std::size_t>(stream.gcount()));
    }
    std::array<char, SHA256_DIGEST_STRING_LENGTH> digits{};
    if (!stream.eof() || SHA256End(&context, digits.data()) == nullptr) {
        throw InputError(file.string() + ": cannot be read; check its name and permissions");
    }
    return digits.data();
}

} // namespace springdrive
