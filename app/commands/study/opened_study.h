// What the commands of a study begin with: its file, and the protocol in it.
#pragma once

#include "app/commands/command.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/store/study_contents.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

struct OpenedStudy {
    study::StudyContents contents;
    study::Protocol protocol;
};

/// "FILE: the deletion of P02 was interrupted; ... completes it", for the first such participant;
/// else empty.
[[nodiscard]] std::string unfinished_removal_text(const study::StudyContents &contents,
                                                  const std::filesystem::path &file);

/// Says on standard error that a deletion was interrupted, and that others have rights to the study
/// or its records.
void warn_of_study(const study::StudyContents &contents, const std::filesystem::path &file);

/// Read and closed again; with the warnings above. @throw InputError as `read_study` and
/// `read_protocol_text` do
[[nodiscard]] OpenedStudy read_opened_study(const std::filesystem::path &file);

/// The protocol that a study was begun with.
[[nodiscard]] study::Protocol protocol_in(const study::StudyContents &contents,
                                          const std::filesystem::path &file);

/// A protocol that was typed. @throw InputError as `read_protocol_file` does, and for a study file,
/// saying what that is
[[nodiscard]] study::Protocol typed_protocol(const std::filesystem::path &file);

/// The study to run: `typed` itself, or the one of the protocol in `typed`, which is created if
/// there is none. A protocol with errors begins none.
/// @param study     the study of a protocol; empty: it has the protocol's name, ending in .study
/// @param accepts   called before a study is created; throws what else speaks against it
/// @throw InputError as `read_protocol_text` and `create_study` do, and for a study that was begun
///        with another protocol
[[nodiscard]] std::filesystem::path
study_to_run(const std::filesystem::path &typed, const std::filesystem::path &study,
             const std::function<void(const study::Protocol &)> &accepts);

/// The study and what may stand beside it: no output may replace them.
[[nodiscard]] std::vector<std::filesystem::path> files_of_study(const std::filesystem::path &file);

/// Where the names in a protocol lead, which is in this file or in the study of this file.
[[nodiscard]] study::ProtocolFolders folders_beside(const std::filesystem::path &file);

/// The positional STUDY of a command.
void add_study_file_argument(Command &command, std::filesystem::path &file);

/// `--device`: which trials a command takes; those on USB unless it is typed.
void add_device_kind_option(Command &command, study::DeviceKind &device);

/// A line on what is left out, if it is anything: "direction.study: 96 trials on the simulated
/// device are left out; --device simulated takes them"; else empty.
[[nodiscard]] std::string left_out_text(const study::StudyContents &contents,
                                        study::DeviceKind taken, const std::filesystem::path &file);

/// @throw InputError if there are no trials on that kind of device, saying what there is
void refuse_without_trials(const study::StudyContents &contents, study::DeviceKind device,
                           const std::filesystem::path &file);

} // namespace springdrive::app
