// The coupling's stiffness over frequency at the active tuning: predicted at once, measured by a
// sine sweep on a simulated motor in the background.
#pragma once

#include "app/plots/plot.h"
#include "base/background.h"
#include "engine/lab/loops/rendered_stiffness.h"

#include <optional>
#include <vector>

namespace springdrive::app {

class StiffnessCurves {
public:
    /// Fetches a finished sweep, and renews the prediction if the tuning changed.
    void update(const loops::SpringDrive &now);

    /// Measures in the background, with the tuning of now.
    void start_sweep();
    [[nodiscard]] bool is_sweeping() const { return sweep_.is_busy(); }
    [[nodiscard]] double share() const { return sweep_.share(); }
    [[nodiscard]] const std::vector<loops::StiffnessPoint> &measured() const { return measured_; }
    /// Whether the active tuning is that of the measurement.
    [[nodiscard]] bool is_of_now() const { return measured_with_ == drive_.tuning; }

    PlotArea draw(Canvas &canvas, const Rectangle &where, const PlotSettings &settings) const;

    /// Magnitudes at a frequency, for the mouse.
    [[nodiscard]] std::string values_at(double frequency_Hz) const;

private:
    loops::SpringDrive drive_;
    bool has_drive_ = false;
    Curve analytic_; ///< (12)
    Curve sampled_;
    Background<std::vector<loops::StiffnessPoint>> sweep_;
    control::Tuning swept_with_;
    control::Tuning measured_with_;
    std::vector<loops::StiffnessPoint> measured_;
};

} // namespace springdrive::app
