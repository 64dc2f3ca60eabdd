// Warnings on what a scene leaves out, with equal ones on several things on one line.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::scene {

/// However many warnings there are, `WarningList::lines` gives no more lines than this.
inline constexpr std::size_t kMaxWarningLines = 60;

class WarningList {
public:
    /// On the file as a whole, or on something that nothing else resembles.
    void add(const std::string &text);

    /// On one of several things.
    /// @param owner what it is, a space and its name: "node 'pad'"
    /// @param identity warnings in a row with the same one count once; null if each counts
    void add_of(const std::string &owner, const void *identity, const std::string &text);

    /// The same for a text that begins with a number; a line gives the sum.
    void add_of(const std::string &owner, const void *identity, std::size_t number,
                const std::string &text);

    /// "node 'a': it is so", or "nodes 'a', 'b', 'c' and 4 more: it is so"; in the order in which
    /// the first of each was added.
    [[nodiscard]] std::vector<std::string> lines() const;

private:
    struct Group {
        std::string kind; ///< "node"
        std::string text;
        bool has_number = false;
        std::size_t number = 0;
        std::size_t count = 0;
        std::vector<std::string> first_names{};
        const void *last_identity = nullptr;
    };

    Group &group_of(const std::string &owner, const void *identity, const std::string &text);

    std::vector<Group> groups_;
    std::map<std::pair<std::string, std::string>, std::size_t> index_; ///< by kind and text
};

} // namespace springdrive::scene
