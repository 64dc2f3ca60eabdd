// Files that the program writes: the names that it chooses itself, and a file that appears under
// its name only when it is complete.
#pragma once

#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>
#include <system_error>

namespace springdrive {

/// A time in a format of strftime, by the local clock; at most 31 letters.
[[nodiscard]] std::string
local_time(const char *format,
           std::chrono::system_clock::time_point when = std::chrono::system_clock::now());

/// "plots-20240531-123456" of "plots", by the local time.
[[nodiscard]] std::string dated_name(std::string_view stem);

/// "touch.rec" of number 1, "touch-2.rec" of number 2.
[[nodiscard]] std::filesystem::path numbered_name(const std::filesystem::path &first,
                                                  std::size_t number);

/// The first of "touch.rec", "touch-2.rec", "touch-3.rec", ... that is not taken.
/// @param is_taken  tells it of a name
template <std::predicate<const std::filesystem::path &> IsTaken>
[[nodiscard]] std::filesystem::path unused_name(const std::filesystem::path &first,
                                                IsTaken &&is_taken, std::size_t number = 1) {
    std::filesystem::path name = numbered_name(first, number);
    while (is_taken(name)) {
        name = numbered_name(first, ++number);
    }
    return name;
}

/// The first from `number` on of which there is no file, folder or link.
[[nodiscard]] std::filesystem::path unused_name(const std::filesystem::path &first,
                                                std::size_t number = 1);

/// What happens to a file that exists under the name of an output.
enum class Existing : std::uint8_t { keep, replace };

/// Who may read a new file. The umask takes from either.
enum class Readers : std::uint8_t {
    all,
    owner, ///< of personal data
};

struct FilePolicy {
    Existing existing = Existing::keep;
    Readers readers = Readers::all;

    /// Implicit: most outputs are for all.
    FilePolicy(Existing of_existing, Readers of_readers = Readers::all)
        : existing(of_existing), readers(of_readers) {}
};

/// Where a file of this name is or would be: absolute, with every symbolic link followed, also one
/// to a file that does not exist. Links of /proc to open files are not followed.
[[nodiscard]] std::filesystem::path resolved_name(const std::filesystem::path &name);

/// The mode for creating a file, from which the system takes the umask.
[[nodiscard]] unsigned creation_mode(Readers readers);

/// Makes a folder, with those above it that are missing, which nobody but its owner can enter.
/// One that is there stays as it is. @return why it cannot be made, if so
[[nodiscard]] std::error_code make_folders_for_owner(const std::filesystem::path &folder);

/// "FILE: others have rights to it (mode 644); ..." if group or others have any to a file or folder
/// that is there; else empty.
[[nodiscard]] std::string others_access_text(const std::filesystem::path &file);

/// Written under a random name in the same folder, and renamed once complete: a file that was there
/// before is lost neither to a failure nor to another program that creates it meanwhile.
class NewFile {
public:
    /// Creates the empty file under its temporary name. One that may be replaced is never readable
    /// by more than that was.
    /// @throw InputError if it cannot be created, or if something other than a regular file has the
    ///        name.
    explicit NewFile(const std::filesystem::path &name, Readers readers = Readers::all);
    /// Removes the temporary file, unless it was published.
    ~NewFile();
    NewFile(const NewFile &) = delete;
    NewFile &operator=(const NewFile &) = delete;

    /// To be written, and closed before `publish`.
    [[nodiscard]] const std::filesystem::path &temporary() const { return temporary_; }

    /// Gives the file its name; one that is replaced passes its permissions on.
    /// @throw InputError if a file exists that is to be kept, or it cannot be renamed.
    void publish(Existing existing);

private:
    std::filesystem::path shown_; ///< as it was typed
    std::filesystem::path name_;
    std::filesystem::path temporary_; ///< empty once published
};

/// "FILE: exists; use --force to replace it".
[[nodiscard]] std::string exists_text(const std::filesystem::path &file);

/// Lets `write` fill a file, which appears when it is complete.
/// @throw InputError if it exists and is to be kept, or cannot be created or written completely; an
///        existing one is then as it was.
void write_file(const std::filesystem::path &file, const std::function<void(std::ostream &)> &write,
                FilePolicy policy);

} // namespace springdrive
