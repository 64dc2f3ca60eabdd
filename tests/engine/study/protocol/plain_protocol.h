// A short protocol without faults, to be spoilt in one place.
#pragma once

#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/study_setting.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <string>

namespace springdrive::testing {

inline const std::string kPlainProtocol = R"(title = "plain"
stimulus = "press"
seed = 7
participants = 4
counterbalancing = "balanced_latin_square"
[texts]
question = "Which?"
[free_space]
dR_Ohm = 0.5
lambda_rad_per_s = 1000.0
[common]
scene = "plate"
point_m = [0.0, -0.005, -0.015]
normal = [0.0, 1.0, 0.0]
hold = "surface"
map = "transpose"
alpha_mode = "on_the_fly"
dR_Ohm = 0.5
K_P_V_per_rad = 6.0
K_D_Vs_per_rad = 0.01
servo_hz = 1000.0
delay_periods = 0.0
press_N = 1.0
[[condition]]
name = "a"
[[condition]]
name = "b"
press_N = 0.8
[variable]
parameter = "eta"
level = "added"
standard = 0.4
[task]
kind = "forced_choice_by_interval"
alternatives = 2
[method]
kind = "constant_stimuli"
levels = [0.1, 0.2, 0.3]
repetitions = 1
blocks = 10
[practice]
levels = [0.3]
fewest_trials = 2
most_trials = 4
[catch_trials]
levels = [0.3]
one_in = 10
[[block]]
name = "one"
conditions = ["a"]
[[block]]
name = "two"
conditions = ["b"]
[responses]
device = "keyboard"
keys = ["1", "2"]
[timing]
approach_s = 1.0
[breaks]
every_trials = 20
[marking]
stiffness_percent = 2.0
repeats = true
[windings]
from_C = 27.0
to_C = 60.0
[stopping]
longest_session_min = 60.0
[expected]
threshold = 0.2
source = "a guess"
[noise]
level_dBFS = -40.0
[[questions]]
name = "hand"
when = "before"
text = "Which hand?"
kind = "choice"
choices = ["right", "left"]
[[questions]]
name = "tiring"
when = "after"
text = "How tiring?"
kind = "scale"
lowest = 1
highest = 5
lowest_label = "not"
highest_label = "very"
[[questions]]
name = "remarks"
when = "after"
text = "Anything else?"
kind = "text"
)";

/// The text with its first `from` replaced by `to`.
inline std::string with(std::string text, const std::string &from, const std::string &to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

inline study::Protocol protocol_of(const std::string &text) {
    return study::read_protocol_text(text, "p.toml");
}

inline study::ProtocolFolders folders() { return {assets(), assets()}; }

} // namespace springdrive::testing
