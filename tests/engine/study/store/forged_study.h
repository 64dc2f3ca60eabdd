// Studies that somebody made to do harm: rows with any path and the right SHA-256, which needs no
// secret, beside files that nobody may touch.
#pragma once

#include "engine/study/store/database.h"
#include "engine/study/store/rows.h"
#include "engine/study/store/study_store.h"
#include "tests/engine/study/store/sample_study.h"
#include "tests/support/files.h"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace springdrive::testing {

class ForgedStudy {
public:
    /// With the participant P01, a session and a trial with a record.
    ForgedStudy(const std::string &name, const study::NewStudy &study) : top_(fresh_folder(name)) {
        for (const char *const kept :
             {"P01/kept", "beside/P01/kept", "in/P01/kept", "in/other.records/P01/kept"}) {
            std::filesystem::create_directories((top_ / kept).parent_path());
            std::ofstream(top_ / kept) << "not of this study";
        }
        study::create_study(file(), study, kStart);
        study::StudyStore store(file());
        store.add({"P01", 1, kStart});
        study::Session session = sample_session(1);
        const study::SessionId id = store.begin(session);
        study::Trial trial = sample_trial(1, 1, 1);
        trial.session = id;
        const auto record = store.new_record_file("P01", trial.place);
        std::ofstream(record) << "of P01";
        trial.record = store.link_to(record);
        store.append(trial);
        store.end(id, study::SessionEnding::stopped, kStart);
        before_ = tree();
    }

    [[nodiscard]] std::filesystem::path file() const { return top_ / "in/h.study"; }
    [[nodiscard]] std::filesystem::path records() const { return top_ / "in/h.records"; }
    [[nodiscard]] std::filesystem::path canary() const { return top_ / "beside/P01/kept"; }

    /// What a program of the forger does to the file.
    void forge(const std::function<void(const study::Database &)> &change) const {
        const study::Database database(file(), file(), study::Access::write, {});
        database.run("PRAGMA foreign_keys = OFF; PRAGMA ignore_check_constraints = ON");
        change(database);
    }
    void forge_records_folder(const std::string &name) const {
        forge([&](const study::Database &database) {
            auto row = study::rows<study::StudyRow>(database).front();
            row.row.facts.records_folder = name;
            study::update(database, row);
        });
    }
    /// P01's deletion was interrupted, as it seems.
    void forge_removal() const {
        forge([](const study::Database &database) {
            auto row = study::rows<study::ParticipantRow>(database).front();
            row.row.is_being_removed = true;
            study::update(database, row);
        });
    }
    /// One whose deletion was interrupted.
    void forge_code(const std::string &code) const {
        forge([&](const study::Database &database) {
            study::insert(database, study::ParticipantRow{{code, 2, kStart}, true});
        });
    }
    void forge_record(const std::string &path) const {
        forge([&](const study::Database &database) {
            auto row = study::rows<study::Trial>(database).front();
            row.row.record->path = path;
            study::update(database, row);
        });
    }
    /// A journal that names a file, which SQLite deletes after it has played the journal back.
    void forge_journal(const std::filesystem::path &names) const {
        constexpr unsigned kPage_bytes = 4096;
        constexpr unsigned kHeader_bytes = 512;
        const std::string magic("\xd9\xd5\x05\xf9\x20\xa1\x63\xd7", 8);
        const auto number = [](unsigned value) {
            std::string bytes;
            for (const unsigned shift : {24U, 16U, 8U, 0U}) {
                bytes += static_cast<char>(value >> shift & 0xffU);
            }
            return bytes;
        };
        const auto pages = std::filesystem::file_size(file()) / kPage_bytes;
        std::string journal = magic + number(0) + number(1) + number(static_cast<unsigned>(pages)) +
                              number(kHeader_bytes) + number(kPage_bytes);
        journal.resize(kHeader_bytes);
        const std::string name = std::filesystem::absolute(names).string();
        unsigned sum = 0;
        for (const char c : name) {
            sum += static_cast<unsigned>(static_cast<signed char>(c));
        }
        journal += number(0x40000000U / kPage_bytes + 1) + name +
                   number(static_cast<unsigned>(name.size())) + number(sum) + magic;
        std::ofstream(file().string() + "-journal", std::ios::binary) << journal;
    }

    /// Whether everything but the study's own file and records is as it was.
    [[nodiscard]] bool is_rest_untouched() const { return tree() == before_; }

private:
    /// Contents, mode and time of each file.
    [[nodiscard]] std::map<std::string, std::string> tree() const {
        std::map<std::string, std::string> all;
        for (const auto &entry : std::filesystem::recursive_directory_iterator(top_)) {
            const std::string name = entry.path().lexically_relative(top_).string();
            if (name.starts_with("in/h.") || !entry.is_regular_file()) {
                continue;
            }
            struct stat found {};
            stat(entry.path().c_str(), &found);
            all[name] = contents_of(entry.path()) + "/" + std::to_string(found.st_mode) + "/" +
                        std::to_string(found.st_mtim.tv_sec) + "." +
                        std::to_string(found.st_mtim.tv_nsec);
        }
        return all;
    }

    std::filesystem::path top_;
    std::map<std::string, std::string> before_;
};

} // namespace springdrive::testing
