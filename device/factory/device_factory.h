// Which device: simulated or USB, by name and serial number; and its life from opening to closing.
//
//   open_device() ──► open ──zero()──► zeroed
//                      ▲ ▲               │
//                      │ └──reconnect()──┤
//                 reconnect()          close()
//                      └──── closed ◄────┘
//
// A device that knows where its rotors stand when it is opened, as the simulated one does, is
// zeroed from the start.
#pragma once

#include "device/core/haptic_device.h"
#include "device/simulated/simulated_world.h"
#include "device/simulated/simulation_options.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::factory {

enum class DeviceKind : std::uint8_t { simulated, usb };

/// By their numbers, as they are typed.
inline constexpr std::array<std::string_view, 2> kDeviceKindNames{"sim", "usb"};

[[nodiscard]] std::optional<DeviceKind> device_kind_named(std::string_view name);

struct DeviceRequest {
    DeviceKind kind = DeviceKind::simulated;
    std::string serial; ///< empty: the only one of its kind
    device::DeviceDescription description;
    double period_s = 1e-3; ///< of the servo

    // Of a simulated device alone.
    simulated::SimulationOptions simulation; ///< but for its period
    Vector3 start_tip_m{Vector3::Zero()};
};

enum class DeviceState : std::uint8_t {
    open,   ///< counts from wherever it was opened
    zeroed, ///< and its counts say where the rotors stand
    closed, ///< braking, and lost to whoever reads it
};

/// Owns a device. Nobody may be within its `read` or `write` while any of this is called.
class OpenDevice {
public:
    /// @param world  of the same device, where it is a simulated one
    OpenDevice(std::unique_ptr<device::HapticDevice> device, simulated::SimulatedWorld *world,
               DeviceState state);
    ~OpenDevice();                                ///< closes
    OpenDevice(OpenDevice &&) noexcept = default; ///< what was moved from may only be assigned to
    OpenDevice &operator=(OpenDevice &&other) noexcept; ///< closes what it had
    OpenDevice(const OpenDevice &) = delete;
    OpenDevice &operator=(const OpenDevice &) = delete;

    /// The same until it is assigned to, open or closed: a closed one says that it is lost.
    [[nodiscard]] device::HapticDevice &device() { return *device_; }
    [[nodiscard]] const device::HapticDevice &device() const { return *device_; }

    /// The world around a simulated device; null for any other.
    [[nodiscard]] simulated::SimulatedWorld *world() { return world_; }

    [[nodiscard]] device::DeviceIdentity identity() const { return device_->identity(); }
    [[nodiscard]] DeviceState state() const { return state_; }

    /// @throw InputError where it is closed
    void zero(const Vector3 &theta_rad);

    /// Harmless twice.
    void close() noexcept;

    /// Has to be zeroed afterwards, whatever it was before.
    /// @throw InputError where it cannot be found; it is closed then
    void reconnect();

private:
    std::unique_ptr<device::HapticDevice> device_;
    simulated::SimulatedWorld *world_;
    DeviceState state_;
};

/// @throw InputError with one line, for a device that is not there, or options that it refuses
[[nodiscard]] OpenDevice open_device(const DeviceRequest &request);

/// What could be opened now.
[[nodiscard]] std::vector<device::DeviceIdentity> devices_present();

} // namespace springdrive::factory
