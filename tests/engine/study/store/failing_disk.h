// A disk that fails, for SQLite: an interface to the system (VFS) between SQLite and the real
// files.
//
// It keeps for each file what is on the disk, and what was written since its last sync. At a chosen
// call of SQLite (a write, a cut, a sync, a deletion) something happens:
//
//   power_loss  From then on every call fails. `lose_power` then leaves what the disk would have:
//               all that was synced; of the rest each sector of 512 bytes, by seed, old, new, or
//               (where it was in the course of being written) part old and part new; names of files
//               that were created or deleted since the folder's last sync, old or new.
//   kill        The process is killed, a write being done by half.
//   full        Every write fails for lack of space, this one after its first half, until
//               `free_space`.
//
// Reads, locks and names are those of the real files. For one study at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace springdrive::testing {

enum class DiskFailure : std::uint8_t { none, power_loss, kill, full };

/// Installs the disk under `kFailingDisk`, once for the process.
inline constexpr const char *kFailingDisk = "failing-disk";
void install_failing_disk();

/// Takes what is in the study's folder as on the disk, and plans a failure.
/// @param at_call  from 0
void plan_failure(const std::filesystem::path &folder, DiskFailure failure,
                  std::uint64_t at_call = 0);

/// Calls so far that could have failed.
[[nodiscard]] std::uint64_t calls_of_disk();

[[nodiscard]] bool has_failed();

void free_space();

/// Leaves in the folder what the disk has after the loss of power. @pre SQLite has closed all files
void lose_power(std::uint64_t seed);

} // namespace springdrive::testing
