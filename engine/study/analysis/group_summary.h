// The mean of a group from estimates of its participants.
#pragma once

#include <span>

namespace springdrive::study {

/// Of one participant, on the scale on which thresholds are compared: u = x or ln x.
struct ParticipantEstimate {
    double value = 0.0;
    double standard_error = 0.0; ///< above 0
};

struct GroupSummary {
    double mean = 0.0;
    double standard_error = 0.0;
    double low = 0.0; ///< of the interval of the mean; ±∞ of a single participant
    double high = 0.0;
    double deviation_between = 0.0; ///< τ, of true values between participants
    double heterogeneity = 0.0;     ///< Cochran's Q
    int participants = 0;
};

/// Random effects: estimate i is N(μ, τ² + sᵢ²). τ² by Paule and Mandel (1982, J. Res. Natl. Bur.
/// Stand. 87, 377), which makes the weighted squares add up to their expectation, N − 1; the mean
/// is weighted with 1/(τ² + sᵢ²), and its standard error and Student's interval are those of
/// Hartung and Knapp (2001, Stat. Med. 20, 3875), never narrower than without them (Röver, Knapp &
/// Friede 2015, BMC Med. Res. Methodol. 15:99). Better for few participants than DerSimonian and
/// Laird's, whose interval is too narrow (Veroniki et al. 2016, Res. Synth. Methods 7, 55).
/// @pre at least one estimate; 0 < confidence < 1
[[nodiscard]] GroupSummary random_effects(std::span<const ParticipantEstimate> estimates,
                                          double confidence = 0.95);

} // namespace springdrive::study
