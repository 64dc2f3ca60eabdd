// One writer at a time: an advisory lock on "STUDY-lock" beside the study, held while it is open
// for writing. The system drops it with the process, however that ends. The file names who holds
// it.
#pragma once

#include <filesystem>
#include <string_view>

namespace springdrive::study {

class StudyLock {
public:
    static constexpr std::string_view kEnding = "-lock";

    /// @param study  resolved name; @param shown  as in messages
    /// @throw InputError, at once, if another program (or this one) holds it, naming that; or if
    ///        the folder is write-protected.
    StudyLock(const std::filesystem::path &study, const std::filesystem::path &shown);
    ~StudyLock();
    StudyLock(const StudyLock &) = delete;
    StudyLock &operator=(const StudyLock &) = delete;

private:
    std::filesystem::path file_;
    int descriptor_ = -1;
};

} // namespace springdrive::study
