#include "app/commands/tune_report.h"

#include "base/print.h"
#include "engine/lab/limits/auto_tune.h"

#include <ostream>

namespace springdrive::app {

void write_tuned(std::ostream &out, const limits::AutoTuned &found) {
    const control::TuningMargins &margins = found.margins;
    print(out, "K_P {:.4g} V/rad, K_D {:.4g} V·s/rad, λ {:.4g} rad/s: K_DC {:.4g} N·m/rad\n",
          found.tuning.K_P_V_per_rad, found.tuning.K_D_Vs_per_rad, found.tuning.lambda_rad_per_s,
          margins.K_DC_Nm_per_rad);
    print(out, "stable in {} loops: every hand, configuration and η\n", found.loops);
    print(out, "margins: K_P and K_D × {:.3g} (then unstable with {} at η {:.2g})", margins.gain,
          loops::hand_text(margins.worst_hand), margins.worst_eta);
    print(out, ", {} more whole periods of delay, dR down to {:.3g} Ω\n",
          margins.more_delay_periods, margins.min_dR_Ohm);
    if (found.tuning.K_P_V_per_rad >= limits::AutoTuneRequest{}.max_K_P_V_per_rad) {
        out << "K_P is at the end of its range: larger values would be stable\n";
    }
    if (found.taken_back > 0.0) {
        print(out,
              "K_P is {:.0f} % below the predicted limit: encoder counts sustained a "
              "vibration\n",
              100.0 * found.taken_back);
    }
}

} // namespace springdrive::app
