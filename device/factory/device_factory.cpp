#include "device/factory/device_factory.h"

#include "base/input_error.h"
#include "device/simulated/simulated_phantom.h"

#include <algorithm>
#include <utility>

namespace springdrive::factory {

namespace {

OpenDevice open_simulated(const DeviceRequest &request) {
    const std::string own_serial = simulated::simulated_identity().serial;
    if (!request.serial.empty() && request.serial != own_serial) {
        throw InputError("there is no simulated device with the serial number '" + request.serial +
                         "'; the only one is '" + own_serial + "'");
    }
    simulated::SimulationOptions options = request.simulation;
    options.servo_period_s = request.period_s;
    auto phantom = std::make_unique<simulated::SimulatedPhantom>(request.description, options,
                                                                 request.start_tip_m);
    simulated::SimulatedWorld *const world = phantom.get();
    return {std::move(phantom), world, DeviceState::zeroed};
}

} // namespace

std::optional<DeviceKind> device_kind_named(std::string_view name) {
    const auto *const found = std::ranges::find(kDeviceKindNames, name);
    if (found == kDeviceKindNames.end()) {
        return std::nullopt;
    }
    return static_cast<DeviceKind>(found - kDeviceKindNames.begin());
}

OpenDevice::OpenDevice(std::unique_ptr<device::HapticDevice> device,
                       simulated::SimulatedWorld *world, DeviceState state)
    : device_(std::move(device)), world_(world), state_(state) {}

OpenDevice::~OpenDevice() { close(); }

OpenDevice &OpenDevice::operator=(OpenDevice &&other) noexcept {
    close();
    device_ = std::move(other.device_);
    world_ = other.world_;
    state_ = other.state_;
    return *this;
}

void OpenDevice::zero(const Vector3 &theta_rad) {
    if (state_ == DeviceState::closed) {
        throw InputError(device_->description().name +
                         " is closed and cannot be zeroed; connect it again");
    }
    device_->zero(theta_rad);
    state_ = DeviceState::zeroed;
}

void OpenDevice::close() noexcept {
    if (device_ && state_ != DeviceState::closed) {
        device_->close();
        state_ = DeviceState::closed;
    }
}

void OpenDevice::reconnect() {
    close();
    device_->reconnect();
    state_ = DeviceState::open;
}

OpenDevice open_device(const DeviceRequest &request) {
    switch (request.kind) {
    case DeviceKind::simulated:
        return open_simulated(request);
    case DeviceKind::usb:
        break;
    }
    throw InputError("--device usb: this version supports only the simulated device; remove the "
                     "option");
}

std::vector<device::DeviceIdentity> devices_present() { return {simulated::simulated_identity()}; }

} // namespace springdrive::factory
