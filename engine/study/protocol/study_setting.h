// What a protocol's names stand for: its device, and the scene and spot of each condition.
#pragma once

#include "device/core/device_description.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/study/protocol/protocol.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::study {

/// Where names lead.
struct ProtocolFolders {
    std::filesystem::path own; ///< of the protocol's file: files that it names are relative to it
    std::filesystem::path assets; ///< of what is included
};

// A file must lie in the protocol's folder: these @throw InputError for one that does not.

/// assets/devices/NAME.toml of an included device, or the file.
[[nodiscard]] std::filesystem::path device_file_of(const Protocol &protocol,
                                                   const ProtocolFolders &folders);

/// assets/scenes/NAME.gltf of an included scene, or the file. @pre the condition has a scene
[[nodiscard]] std::filesystem::path scene_file_of(const Condition &condition,
                                                  const ProtocolFolders &folders);

/// One of a study's conditions, ready to be looked at.
struct PlacedCondition {
    std::shared_ptr<const contact::HapticSurface> surface; ///< null in free space
    scene::TouchSpot spot;    ///< in free space the place where the hand rests
    double surface_eta = 0.0; ///< of the material at the spot; 1 in free space
    /// Why it cannot be used, with what to do; then the rest is as far as it came.
    std::string problem;
};

struct StudySetting {
    device::DeviceDescription device;
    std::vector<PlacedCondition> conditions; ///< in the protocol's order
    double global_alpha_rad2_per_m2 = 0.0;   ///< of control::AlphaMode::global
};

/// Loads the device and all scenes; each scene once.
/// @throw InputError if the device cannot be read.
[[nodiscard]] StudySetting study_setting(const Protocol &protocol, const ProtocolFolders &folders);

/// Height above the spot, along its normal, at which a trial begins.
inline constexpr double kApproach_m = 0.02;

/// A stroke goes so far to either side of the spot, along the device's x axis.
inline constexpr double kStroke_m = 0.03;

} // namespace springdrive::study
