// Remarks of a session for the user, each one once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace springdrive::session {

class Remarks {
public:
    /// One line, with a remedy after a semicolon. Ignored if it was added before.
    void add(const std::string &text) {
        if (std::ranges::find(all_, text) == all_.end()) {
            all_.push_back(text);
        }
    }

    [[nodiscard]] const std::vector<std::string> &all() const { return all_; }

    /// The remarks not yet taken, for printing.
    [[nodiscard]] std::vector<std::string> take_new() {
        const auto first = all_.begin() + static_cast<std::ptrdiff_t>(taken_);
        taken_ = all_.size();
        return {first, all_.end()};
    }

private:
    std::vector<std::string> all_;
    std::size_t taken_ = 0;
};

} // namespace springdrive::session
