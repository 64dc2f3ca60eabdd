// Offsets of the current sensors, measured while the windings are open and carry no current.
#pragma once

#include "device/usb/board/matrix.h"

namespace springdrive::board {

class CurrentOffsets {
public:
    /// After opening, currents decay through the power stages' diodes; then the mean is taken.
    static constexpr int kSettlingLoops = 128;
    static constexpr int kMeasuredLoops = 1024; ///< noise of the mean: 1/32 of a sample's

    enum class Progress : std::uint8_t { measuring, ready, failed };

    void restart() { *this = CurrentOffsets(); }

    [[nodiscard]] Progress update(const Triple &current_A, float largest_A) {
        if (++loops_ <= kSettlingLoops) {
            return Progress::measuring;
        }
        for (std::size_t i = 0; i < kChannels; ++i) {
            sum_A_[i] += current_A[i];
        }
        if (loops_ < kSettlingLoops + kMeasuredLoops) {
            return Progress::measuring;
        }
        bool is_plausible = true;
        for (std::size_t i = 0; i < kChannels; ++i) {
            offset_A_[i] = sum_A_[i] * (1.0F / static_cast<float>(kMeasuredLoops));
            is_plausible = is_plausible && magnitude(offset_A_[i]) <= largest_A; // not for NaN
        }
        return is_plausible ? Progress::ready : Progress::failed;
    }

    [[nodiscard]] const Triple &offset_A() const { return offset_A_; }

private:
    int loops_ = 0;
    Triple sum_A_{};
    Triple offset_A_{};
};

} // namespace springdrive::board
