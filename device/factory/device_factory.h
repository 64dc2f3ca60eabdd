// Opens a device, simulated, on USB or emulated, by name and serial number, and manages it until it
// is closed.
//
//   open_device() ──► open ──zero()──► zeroed
//                      ▲ ▲               │
//                      │ └──reconnect()──┤
//                 reconnect()          close()
//                      └──── closed ◄────┘
//
// A device that knows its rotors' angles when it is opened or connected again is zeroed from then
// on: the simulated one, and a board that kept its counts.
#pragma once

#include "device/core/haptic_device.h"
#include "device/factory/emulated_device.h"
#include "device/simulated/simulation_options.h"
#include "device/usb/emulator/emulated_board.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::factory {

enum class DeviceKind : std::uint8_t {
    simulated,
    usb,
    emulated, ///< a board in this process, see EmulatedDevice
};

/// As typed on the command line, indexed by DeviceKind.
inline constexpr std::array<std::string_view, 3> kDeviceKindNames{"sim", "usb", "emulated"};

[[nodiscard]] std::optional<DeviceKind> device_kind_named(std::string_view name);

struct DeviceRequest {
    DeviceKind kind = DeviceKind::simulated;
    std::string serial; ///< empty: the only one of its kind
    device::DeviceDescription description;
    double period_s = 1e-3; ///< of the servo
    bool has_clock = true;  ///< whether the servo has; otherwise the device paces it, in lockstep

    // For a simulated device only.
    simulated::SimulationOptions simulation; ///< except its period; of an emulated one the plant's
    Vector3 start_tip_m{Vector3::Zero()};

    EmulationOptions emulation; ///< for an emulated device only
};

enum class DeviceState : std::uint8_t {
    open,   ///< counts relative to the position at opening
    zeroed, ///< counts give the rotors' angles
    closed, ///< braking; reads report that it is lost
};

/// Owns a device. No thread may be inside its `read` or `write` while a member is called.
class OpenDevice {
public:
    /// @param world  the world of the device, if it is simulated
    OpenDevice(std::unique_ptr<device::HapticDevice> device, simulated::SimulatedWorld *world);
    explicit OpenDevice(std::unique_ptr<EmulatedDevice> device);
    explicit OpenDevice(std::unique_ptr<usb::UsbDevice> device);
    ~OpenDevice();                                      ///< closes
    OpenDevice(OpenDevice &&) noexcept = default;       ///< the source may then only be assigned to
    OpenDevice &operator=(OpenDevice &&other) noexcept; ///< closes the previous device
    OpenDevice(const OpenDevice &) = delete;
    OpenDevice &operator=(const OpenDevice &) = delete;

    /// The same object until this is assigned to, open or closed: a closed one reports that it is
    /// lost.
    [[nodiscard]] device::HapticDevice &device() { return *device_; }
    [[nodiscard]] const device::HapticDevice &device() const { return *device_; }

    /// The world around a simulated device; null for any other.
    [[nodiscard]] simulated::SimulatedWorld *world() { return world_; }
    [[nodiscard]] bool has_world() const { return world_ != nullptr; }

    /// The simulated hand that holds a simulated or emulated device; null for a real hand.
    [[nodiscard]] simulated::HandControl *hand() { return hand_; }

    /// Null unless it is an emulated one.
    [[nodiscard]] EmulatedDevice *emulated() { return emulated_; }

    [[nodiscard]] device::DeviceIdentity identity() const { return device_->identity(); }
    [[nodiscard]] DeviceState state() const;

    /// Makes the calibration part of a board's description, instead of any that it has.
    /// @throw InputError if it is another device's, or impossible for this one, or this is no board
    void take_calibration(const device::Calibration &calibration);

    /// @throw InputError if it is closed
    void zero(const Vector3 &theta_rad);

    /// May be called twice.
    void close() noexcept;

    /// Must be zeroed afterwards, unless it kept its counts.
    /// @throw InputError if it cannot be found; it is then closed
    void reconnect();

private:
    std::unique_ptr<device::HapticDevice> device_;
    simulated::SimulatedWorld *world_;
    simulated::HandControl *hand_;
    EmulatedDevice *emulated_ = nullptr;
    usb::UsbDevice *usb_ = nullptr; ///< of one on USB
    bool is_closed_ = false;
};

/// @throw InputError with one line, for a device that is absent, options that it rejects, or a
///        description with the calibration of another device
[[nodiscard]] OpenDevice open_device(const DeviceRequest &request);

/// For a device that was just opened: uses the calibration that its board has stored, unless the
/// device file has one.
/// @throw InputError if the file's is another device's, or the board's is damaged or impossible
void use_calibration(usb::UsbDevice &device);

/// A device that is there, and why it cannot be used, with what to do; empty if it can.
struct PresentDevice {
    DeviceKind kind = DeviceKind::simulated;
    std::string serial;
    std::string problem;
};

/// Asks all USB devices for their serial numbers, which takes milliseconds.
[[nodiscard]] std::vector<PresentDevice> devices_present();

/// For the commissioning of a board: one on USB, or an emulated one in this process.
struct BoardRequest {
    DeviceKind kind = DeviceKind::simulated;
    std::string serial;                    ///< of a board on USB; empty: the only one
    device::DeviceDescription description; ///< what its host takes it for
    double period_s = 1e-3;                ///< of its reports, which pace `read`
    /// Without a command, after which the board brakes by itself. A thread that drives nothing need
    /// not be a servo's: only a long silence then means that it ended.
    double watchdog_periods = 50.0;
    /// Whether calibrations do not matter, in the file or on the board, of whatever device: the
    /// description is then without one.
    bool ignores_calibration = false;

    // For an emulated board only.
    device::DeviceDescription truth; ///< what it is
    emulator::EmulatedBoardOptions emulation;
};

/// A board, with its `Bench`.
struct OpenBoard {
    std::unique_ptr<emulator::EmulatedBoard> emulated; ///< null for one on USB
    std::unique_ptr<device::HapticDevice> device;      ///< closes itself first
};

/// @throw InputError with one line, as `open_device` does
[[nodiscard]] OpenBoard open_board(const BoardRequest &request);

} // namespace springdrive::factory
