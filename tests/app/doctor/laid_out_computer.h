// A computer laid out in a folder, and evidence about it in which nothing is wrong.
#pragma once

#include "app/doctor/checks.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace springdrive::app::doctor {

class LaidOutComputer {
public:
    LaidOutComputer() : root_(testing::fresh_folder("computer")) {}

    void has(const std::string &path, const std::string &contents = "") {
        const std::filesystem::path file = root_ / path.substr(1);
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file, std::ios::binary) << contents;
    }
    void has_program(const std::string &path) {
        has(path);
        std::filesystem::permissions(root_ / path.substr(1), std::filesystem::perms::owner_all);
    }
    void has_link(const std::string &path, const std::string &target) {
        const std::filesystem::path link = root_ / path.substr(1);
        std::filesystem::create_directories(link.parent_path());
        std::filesystem::create_symlink(target, link);
    }
    void has_no(const std::string &path) { std::filesystem::remove_all(root_ / path.substr(1)); }

    [[nodiscard]] const std::filesystem::path &root() const { return root_; }
    [[nodiscard]] Machine machine() const { return Machine(root_); }

    /// Of an ordinary user, with everything granted.
    [[nodiscard]] Evidence evidence() const {
        Evidence all;
        all.machine = machine();
        all.process.user_id = 1000;
        all.process.group_ids = {1000};
        all.process.architecture = "amd64";
        all.process.setup_folder = root_ / "source/setup"; // which is not there
        all.probes.rights = {true, 80, 0, true, true};
        all.probes.picture = {true, "", "", "4.6 (Core Profile) Mesa 23.2", "Mesa Intel UHD"};
        all.probes.disk = {true, 0, 200e6, 0.002, 50e9};
        all.probes.usb.has_answered = true;
        return all;
    }

private:
    std::filesystem::path root_;
};

[[nodiscard]] inline const Check &check_named(const std::vector<Check> &checks,
                                              const std::string &id) {
    static const Check kNone;
    const auto found = std::ranges::find(checks, id, &Check::id);
    EXPECT_NE(found, checks.end()) << id;
    return found == checks.end() ? kNone : *found;
}

inline void expect_ok(const Finding &check, const std::string &found) {
    EXPECT_EQ(name_of(check.verdict), "ok") << check.found;
    EXPECT_NE(check.found.find(found), std::string::npos) << check.found;
    EXPECT_EQ(check.fix, "");
}

/// @param found  part of it
/// @param repair   all of it
inline void expect_wrong(const Finding &check, Verdict verdict, const std::string &found,
                         const std::string &fix) {
    EXPECT_EQ(name_of(check.verdict), name_of(verdict)) << check.found;
    EXPECT_NE(check.found.find(found), std::string::npos) << check.found;
    EXPECT_EQ(check.fix, fix);
    EXPECT_EQ(check.fix.find('\n'), std::string::npos);
}

inline void expect_no_verdict(const Finding &check, const std::string &found) {
    EXPECT_EQ(name_of(check.verdict), "not applicable") << check.found;
    EXPECT_NE(check.found.find(found), std::string::npos) << check.found;
    EXPECT_EQ(check.fix, "");
}

} // namespace springdrive::app::doctor
