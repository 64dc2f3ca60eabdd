#include "base/sha256.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/input_error.h"

#include <sha2.h>

#include <array>
#include <fstream>
#include <vector>

namespace springdrive {

struct Sha256::State {
    SHA2_CTX context{};
    bool is_complete = false; ///< `hex` was called
};

Sha256::Sha256() : state_(std::make_unique<State>()) { SHA256Init(&state_->context); }

Sha256::~Sha256() = default;

void Sha256::add(const void *bytes, std::size_t count) {
    SPRINGDRIVE_ASSERT(!state_->is_complete);
    SHA256Update(&state_->context, static_cast<const std::uint8_t *>(bytes), count);
}

void Sha256::add(std::string_view text) {
    add(std::uint64_t{text.size()});
    add(text.data(), text.size());
}

std::string Sha256::hex() {
    SPRINGDRIVE_ASSERT(!state_->is_complete);
    state_->is_complete = true;
    std::array<char, SHA256_DIGEST_STRING_LENGTH> digits{};
    SHA256End(&state_->context, digits.data());
    return digits.data();
}

std::string sha256_of_file(const std::filesystem::path &file) {
    std::ifstream stream(file, std::ios::binary);
    Sha256 sha256;
    std::vector<char> block(std::size_t{1} << 20U);
    while (stream) {
        stop_if_given_up();
        stream.read(block.data(), static_cast<std::streamsize>(block.size()));
        sha256.add(block.data(), static_cast<std::size_t>(stream.gcount()));
    }
    if (!stream.eof()) {
        throw InputError(file.string() + ": cannot be read; check its name and permissions");
    }
    return sha256.hex();
}

} // namespace springdrive
