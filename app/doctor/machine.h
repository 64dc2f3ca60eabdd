// What the kernel and the system's files say about a computer, and what this process may do on it.
// Both are values, so that tests can lay out any other computer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::doctor {

/// The files of a computer. Whatever they contain, nothing here throws, waits or reads without end.
class Machine {
public:
    /// @param root  the folder that stands for "/"
    explicit Machine(std::filesystem::path root = "/") : root_(std::move(root)) {}

    /// The contents on one line, in printable ASCII; none if it cannot be read or is no file.
    [[nodiscard]] std::optional<std::string> text(std::string_view path) const;
    [[nodiscard]] std::optional<std::int64_t> number(std::string_view path) const;
    /// The lines of a file as they are, at most its first 256 KiB; none if it cannot be read.
    [[nodiscard]] std::vector<std::string> lines(std::string_view path) const;
    [[nodiscard]] bool exists(std::string_view path) const;
    [[nodiscard]] bool is_program(std::string_view path) const;
    /// The names in a folder, sorted, cpu2 before cpu10; none if it cannot be read.
    [[nodiscard]] std::vector<std::string> names_in(std::string_view folder) const;
    /// Where a link points; empty if it is none.
    [[nodiscard]] std::string target_of(std::string_view link) const;

    [[nodiscard]] bool is_container() const;
    [[nodiscard]] bool is_debian() const; ///< or based on it
    [[nodiscard]] bool is_ubuntu() const;

private:
    [[nodiscard]] std::filesystem::path at(std::string_view path) const;
    [[nodiscard]] std::optional<std::string> contents(std::string_view path,
                                                      std::size_t most) const;

    std::filesystem::path root_;
};

/// This process, and who runs it.
struct Process {
    static constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

    unsigned user_id = 0; ///< effective
    std::int64_t parent_id = 0;
    std::vector<unsigned> group_ids;
    std::uint64_t priority_limit = 0; ///< RLIMIT_RTPRIO, soft and hard
    std::uint64_t priority_limit_hard = 0;
    std::uint64_t memory_lock_limit_bytes = 0; ///< RLIMIT_MEMLOCK
    std::uint64_t memory_lock_limit_hard_bytes = 0;
    std::string architecture; ///< as Debian names it
    std::map<std::string, std::string, std::less<>> environment;
    std::filesystem::path setup_folder; ///< of the source tree; may not exist

    /// Of the environment; empty if it is not set.
    [[nodiscard]] std::string variable(std::string_view name) const;
    [[nodiscard]] bool is_root() const { return user_id == 0; }
    /// Before a command that only root may run.
    [[nodiscard]] std::string sudo() const { return is_root() ? "" : "sudo "; }
};

/// @param setup_folder  with the files that repairing lines copy
[[nodiscard]] Process this_process(const std::filesystem::path &setup_folder);

/// The line that installs a package.
[[nodiscard]] std::string install_line(const Machine &machine, const Process &process,
                                       const std::string &package);

/// A word of a shell's command line, in single quotes if it needs them.
[[nodiscard]] std::string shell_word(const std::string &word);

} // namespace springdrive::app::doctor
