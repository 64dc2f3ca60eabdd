#include "app/figures/figure_text.h"

#include <fmt/core.h>

#include <cmath>
#include <string>

namespace springdrive::app {

std::string number_text(double number, int digits) {
    return std::isnan(number) ? "" : fmt::format("{:.{}g}", number, digits);
}

std::string gains_text(const FigureSetting &setting) {
    const control::Tuning &tuning = setting.tuning;
    return "dR " + number_text(tuning.dR_Ohm, 4) + " Ω, K_P " +
           number_text(tuning.K_P_V_per_rad, 4) + " V/rad, K_D " +
           number_text(tuning.K_D_Vs_per_rad, 4) + " V·s/rad, servo " +
           number_text(1.0 / setting.servo_period_s, 4) + " Hz";
}

std::string tuning_text(const FigureSetting &setting) {
    return gains_text(setting) + ", λ " + number_text(setting.tuning.lambda_rad_per_s, 4) +
           " rad/s";
}

std::string angles_text(const FigureSetting &setting) {
    std::string text = "q";
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double angle_deg = kDegreesPerRadian * setting.q_rad[j];
        text += std::string(j == 0 ? " " : ", ") + (angle_deg < 0.0 ? "−" : "") +
                number_text(std::abs(angle_deg), 4) + "°";
    }
    return text;
}

} // namespace springdrive::app
