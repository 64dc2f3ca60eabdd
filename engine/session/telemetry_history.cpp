#include "engine/session/telemetry_history.h"

namespace springdrive::session {

void TelemetryHistory::set_device(const device::PhantomGeometry &geometry) {
    row_.set_device(geometry);
    if (!store_.is_empty()) {
        start_s_ = store_.time_s(store_.end() - 1) + 1.0 / servo_hz();
    }
}

} // namespace springdrive::session
