#include "tests/support/fault_case.h"

#include "engine/control/tuning_file.h"
#include "tests/support/devices.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>

namespace springdrive::testing {

double uniform(std::mt19937 &random, double minimum, double maximum) {
    return std::uniform_real_distribution<double>(minimum, maximum)(random);
}

double log_uniform(std::mt19937 &random, double minimum, double maximum) {
    return std::exp(uniform(random, std::log(minimum), std::log(maximum)));
}

device::HandParameters FaultCase::hand() const {
    device::HandParameters hand = firm ? kFirmHand : kLightHand;
    hand.max_speed_m_per_s = hand_m_per_s;
    return hand;
}

std::string FaultCase::description() const {
    std::ostringstream text;
    text << tuning_name << " at " << servo_hz << " Hz, " << (firm ? "firm" : "light")
         << " hand from (" << start_m.transpose() << ") to (" << target_m.transpose() << ") at "
         << hand_m_per_s << " m/s, fault in tick " << at_tick;
    return text.str();
}

FaultCase random_case(std::mt19937 &random, int number, Place place) {
    FaultCase what;
    what.servo_hz = number % 12 == 7 ? 10'000.0 : (number / 3 % 2 == 0 ? 1000.0 : 4000.0);
    const std::array<std::string, 3> tunings{
        "firm", "soft", what.servo_hz < 4000.0 ? "stiffest_1kHz" : "stiffest_4kHz"};
    what.tuning_name = tunings[static_cast<std::size_t>(number % 3)];
    what.tuning = control::read_tuning_file(assets() / "tunings" / (what.tuning_name + ".toml"));
    what.firm = number / 6 % 2 == 0;
    what.on_plate = place == Place::plate || place == Place::running_on_plate ||
                    (place == Place::anywhere && number / 12 % 2 == 0);
    const auto across = [&] { return uniform(random, -0.04, 0.04); };
    what.start_m = {across(), uniform(random, 0.012, 0.03), across()};
    what.target_m = {across(), uniform(random, 0.012, 0.03), across()};
    what.hand_m_per_s = log_uniform(random, 0.05, 0.4);
    if (what.on_plate) { // pressing with 1 N to 4 N on about 1.5 N/mm
        what.target_m = what.start_m + Vector3(0.005, 0.0, -0.003);
        what.target_m.y() = -uniform(random, 1.0, 2.5) * (what.firm ? 1.5e-3 : 11e-3);
        what.hand_m_per_s = log_uniform(random, 0.12, 0.4);
    }
    double earliest_s = what.on_plate ? 0.85 : 0.02;
    if (place == Place::running_free || place == Place::running_on_plate) {
        earliest_s = 1.15;
    }
    what.at_tick =
        static_cast<std::uint64_t>(what.servo_hz * uniform(random, earliest_s, 1.45)) + 2;
    return what;
}

} // namespace springdrive::testing
