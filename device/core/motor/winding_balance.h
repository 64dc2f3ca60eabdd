// Whether a winding generates: whether its R̂ is above its R, whatever anybody believes of either.
//
// With (6) and the voltage V_b of brushes and bridge, (11) is
//
//   L di/dt = e_W − dR i − V_b sgn(i) − k_T θ̇
//
// Over a time in which the current keeps its sign s, its integral is
//
//   W = s [∫e_W dt − k_T Δθ − L Δi] = dR ∫|i| dt + V_b t ≥ 0      as long as dR ≥ 0
//
// Neither R, R̂ nor V_b is on the left: a negative W means that the winding generates. This is the
// balance of its energy by the current. Multiplied by i, ∫ i (e_W − k_T θ̇) dt − ½ L Δ(i²), it would
// hold through a change of sign, too, but needs the mean current of an interval, which takes dR to
// know, and the covariance of current and speed in it. Here e_W, θ and i telescope: what is not
// known of them counts once, at both ends, however many intervals there are.
//
//   rounding of counts   k_T times one count                            36 µV·s
//   noise of i           L (6 √2 σ + resolution)                         7 µV·s
//
// What grows with the intervals is taken at its worst, too:
//
//   offset o of i        (6) feeds R̂ (i + o) back: R̂ o adds to e_W. It is what the sensor may
//                        have, until it is measured: a braked motor that stands has no current
//   k_T and e_W          shares of k_T |Δθ| and |e_W| T
//   L and gain of i      a share of L |Δi|
//   delay of e_W         its error times |each step|, that of the next command included
//
// A cumulative sum (Page) finds the worst window: S ← max(0, S − W − all of the second kind). It
// exceeds the first kind only if dR < 0; at dR −0.3 Ω and 0.17 A after 1.2 ms. With errors beyond
// these a healthy winding can be taken for one that generates, which costs stiffness.
//
// Then R + V_b/|ī| is R̂ + W/∫|i| dt, of which V_b is not known. What R̂ is lowered to is
//
//   R̂ + (2 W − V_b,max t)/∫|i| dt = 2 R − R̂ − (V_b,max − 2 V_b)/|ī|
//
// with R̂ the mean by the charge: without brushes twice the excess over R, so that as much is left.
// If V_b is more than half of its maximum, it may have to fall again. The mean current is that of
// the ends: at dR T/L = −2 it is 1.3 times the true one, which the factor 2 covers.
#pragma once

namespace springdrive::device {

/// What is known of a winding, and how well. For boards and hosts alike: freestanding.
struct BalanceSettings {
    float resistance_Ohm = 0.0F; ///< at most
    float inductance_H = 0.0F;
    float torque_constant_Nm_per_A = 0.0F;
    float count_rad = 0.0F;    ///< of the encoder
    float noise_A = 0.0F;      ///< of two currents' difference, at most
    float max_offset_A = 0.0F; ///< of the currents
    float delay_s = 0.0F;      ///< by which e_W may act earlier or later, at most
    float max_brush_V = 0.0F;  ///< V_b
    /// Whether R̂ is fed back by the sensor that is read here, so that its offset can be measured.
    bool is_shared = true;
};

/// Between two measurements of a motor; |e_W| and |R̂ i| within what the amplifier can do.
struct BalanceInterval {
    float duration_s = 0.0F;
    float e_W_V = 0.0F;      ///< mean
    float last_e_W_V = 0.0F; ///< at its end
    float next_e_W_V = 0.0F; ///< of the commands that are to act after it, as far as known
    float R_hat_Ohm = 0.0F;
    float before_A = 0.0F; ///< currents at its ends
    float after_A = 0.0F;
    float turned_rad = 0.0F;
};

/// The balance of one winding. RT-safe.
class WindingBalance {
public:
    static constexpr float kTorqueConstant = 0.15F; ///< magnets lose 0.2 %/K; tolerance
    static constexpr float kAmplifier = 0.02F;
    static constexpr float kInductance = 0.25F; ///< as a self-test lets it differ
    /// Currents below this [A] may have the other sign in an interval's middle.
    static constexpr float kLeast_A = 0.1F;
    /// For how long a motor has to stand for its offset [s], and what is then left of it [A].
    static constexpr float kRest_s = 0.1F;
    static constexpr float kMeasured_A = 0.004F;

    WindingBalance() = default;
    explicit WindingBalance(const BalanceSettings &settings)
        : settings_(settings), offset_V_(settings.resistance_Ohm * settings.max_offset_A),
          limit_Vs_(settings.torque_constant_Nm_per_A * settings.count_rad +
                    settings.inductance_H * settings.noise_A) {}

    void set_delay(float delay_s) noexcept { settings_.delay_s = delay_s; }

    /// After a time that is not known, or in which the amplifier was at its limits.
    void forget() noexcept {
        begin();
        is_next_ = false;
        rest_s_ = 0.0F;
    }

    /// Takes back what was found.
    void reset() noexcept {
        forget();
        limit_Ohm_ = kNoLimit_Ohm;
    }

    void update(const BalanceInterval &now) noexcept {
        const float T = now.duration_s;
        const float step_V = size(now.last_e_W_V - last_e_W_V_);
        const bool has_step = is_next_;
        last_e_W_V_ = now.last_e_W_V;
        is_next_ = true;
        measure_offset(now);
        const float before_A = now.before_A - offset_A_;
        const float after_A = now.after_A - offset_A_;
        const float sign = after_A < 0.0F ? -1.0F : 1.0F;
        const float turned_Vs = settings_.torque_constant_Nm_per_A * now.turned_rad;
        const float changed_Vs = settings_.inductance_H * (after_A - before_A);
        const float driven_Vs = (now.e_W_V + now.R_hat_Ohm * offset_A_) * T;
        const float balance_Vs = sign * (driven_Vs - turned_Vs - changed_Vs);
        const float errors_Vs = offset_V_ * T + kTorqueConstant * size(turned_Vs) +
                                kAmplifier * size(now.e_W_V) * T + kInductance * size(changed_Vs) +
                                settings_.delay_s * step_V;
        const float rise_Vs = -(balance_Vs + errors_Vs);
        if (!(has_step && sign * before_A > kLeast_A && sign * after_A > kLeast_A &&
              excess_Vs_ + rise_Vs > 0.0F)) { // nor for NaN
            begin();
            return;
        }
        const float charge_As = 0.5F * size(before_A + after_A) * T;
        excess_Vs_ += rise_Vs;
        balance_Vs_ += balance_Vs;
        charge_As_ += charge_As;
        window_s_ += T;
        R_hat_Vs_ += now.R_hat_Ohm * charge_As;
        const float pending_Vs = settings_.delay_s * size(now.next_e_W_V - now.last_e_W_V);
        if (excess_Vs_ > limit_Vs_ + pending_Vs) {
            const float limit_Ohm =
                (R_hat_Vs_ + 2.0F * balance_Vs_ - settings_.max_brush_V * window_s_) / charge_As_;
            limit_Ohm_ = limit_Ohm < limit_Ohm_ ? limit_Ohm : limit_Ohm_;
            limit_Ohm_ = limit_Ohm_ > 0.0F ? limit_Ohm_ : 0.0F;
        }
    }

    /// Whether the winding was found to generate since the last reset.
    [[nodiscard]] bool generates() const noexcept { return limit_Ohm_ < kNoLimit_Ohm; }
    /// The largest R̂ that it may be driven with by what was found.
    [[nodiscard]] float limit_Ohm() const noexcept { return limit_Ohm_; }

private:
    static constexpr float kNoLimit_Ohm = 1e9F;

    [[nodiscard]] static constexpr float size(float value) { return value < 0.0F ? -value : value; }

    /// Of a window.
    void begin() noexcept { excess_Vs_ = balance_Vs_ = charge_As_ = R_hat_Vs_ = window_s_ = 0.0F; }

    /// While the motor brakes at rest: its current is what its back-EMF leaves.
    void measure_offset(const BalanceInterval &now) noexcept {
        if (!settings_.is_shared || now.R_hat_Ohm != 0.0F || now.e_W_V != 0.0F ||
            now.last_e_W_V != 0.0F) {
            rest_s_ = 0.0F;
            return;
        }
        if (rest_s_ == 0.0F) {
            rest_As_ = rest_rad_ = 0.0F;
        }
        rest_s_ += now.duration_s;
        rest_As_ += 0.5F * (now.before_A + now.after_A) * now.duration_s;
        rest_rad_ += size(now.turned_rad);
        if (rest_s_ < kRest_s) {
            return;
        }
        const float mean_A = rest_As_ / rest_s_;
        const float moved_V = settings_.torque_constant_Nm_per_A * rest_rad_ / rest_s_;
        if (size(mean_A) <= settings_.max_offset_A + kMeasured_A &&
            moved_V <= kMeasured_A * settings_.resistance_Ohm) {
            offset_A_ = mean_A;
            offset_V_ = 1.5F * kMeasured_A * settings_.resistance_Ohm;
        }
        rest_s_ = 0.0F;
    }

    BalanceSettings settings_;
    float offset_A_ = 0.0F;
    float offset_V_ = 0.0F; ///< R times what is not known of it, at most
    float limit_Vs_ = 0.0F;

    // The window.
    float excess_Vs_ = 0.0F;  ///< S
    float balance_Vs_ = 0.0F; ///< W
    float charge_As_ = 0.0F;  ///< ∫|i| dt
    float R_hat_Vs_ = 0.0F;   ///< ∫R̂ |i| dt
    float window_s_ = 0.0F;
    float last_e_W_V_ = 0.0F;
    bool is_next_ = false; ///< the interval before is known

    // At rest.
    float rest_s_ = 0.0F;
    float rest_As_ = 0.0F;
    float rest_rad_ = 0.0F;

    float limit_Ohm_ = kNoLimit_Ohm;
};

} // namespace springdrive::device
