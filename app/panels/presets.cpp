#include "app/panels/presets.h"

namespace springdrive::app {

std::string preset_file(std::string_view label, double servo_hz, double delay_periods) {
    // A rate of 1000 Hz is kept as a period of 1 ms, and may return as 999.99….
    constexpr double kRoundOff = 1.0 + 1e-9;
    std::string file;
    for (const Preset &preset : kPresets) {
        const bool fits = preset.min_servo_hz == 0.0 ||
                          (servo_hz * kRoundOff >= preset.min_servo_hz && delay_periods == 0.0);
        if (preset.label == label && fits) {
            file = preset.file;
        }
    }
    return file;
}

} // namespace springdrive::app
