#include "engine/study/protocol/protocol_check.h"

#include "engine/study/protocol/checks.h"
#include "engine/study/protocol/warm_up_trial.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <string_view>
#include <utility>

namespace springdrive::study {

namespace {

void add(ProtocolFindings &all, ProtocolFindings more) {
    std::ranges::move(more, std::back_inserter(all));
}

/// Only of conditions whose spot can be used.
std::vector<Presented> usable(const std::vector<Presented> &all, const StudySetting &setting) {
    std::vector<Presented> some;
    std::ranges::copy_if(all, std::back_inserter(some), [&setting](const Presented &one) {
        const PlacedCondition &place = setting.conditions[one.condition];
        return place.problem.empty() &&
               device::can_reach(setting.device,
                                 place.spot.point_m + kApproach_m * place.spot.normal);
    });
    return some;
}

} // namespace

CheckedProtocol check_protocol(const Protocol &protocol, const ProtocolFolders &folders,
                               const CheckOptions &options) {
    const StudySetting setting = study_setting(protocol, folders);
    const std::vector<Presented> presented = all_presented(protocol);
    CheckedProtocol checked;
    const double warm_up_s = predicted_warm_up_s(protocol, setting);
    checked.length = session_length(protocol, std::isfinite(warm_up_s) ? warm_up_s : 0.0);
    ProtocolFindings &findings = checked.findings;
    add(findings, check_spots(protocol, setting));
    add(findings, check_free_space(protocol, setting.device));
    add(findings, check_stability(protocol, setting, presented));
    add(findings, check_limits(protocol, setting, presented));
    SessionWarmth warmth = check_warmth(protocol, setting, presented, checked.length);
    if (!std::isfinite(warm_up_s)) {
        findings.push_back(
            {Severity::error, "windings",
             fmt::format("cannot be warmed to {:g} °C in {:g} min, with air of {:g} °C",
                         protocol.windings.from_C, WarmUp::kMax_s / 60.0, protocol.windings.air_C),
             "lower windings.from_C, or raise windings.to_C"});
    }
    checked.hottest_winding_C = warmth.hottest_C;
    add(findings, std::move(warmth.findings));
    add(findings, check_marking(protocol, setting, presented));
    add(findings, check_session(protocol, checked.length));
    if (options.simulates && !has_errors(findings)) {
        checked.trials = try_conditions(protocol, setting, usable(extremes(presented), setting));
        add(findings, findings_of(protocol, checked.trials));
    } else if (options.simulates) {
        findings.push_back({Severity::note, "simulation",
                            "was left out: it comes when the errors are mended", ""});
    }
    add(findings, check_precision(protocol));
    std::ranges::stable_sort(findings, {}, &ProtocolFinding::severity);
    return checked;
}

bool has_errors(const ProtocolFindings &findings) {
    return std::ranges::any_of(findings, [](const ProtocolFinding &finding) {
        return finding.severity == Severity::error;
    });
}

std::string text_of(const ProtocolFinding &finding) {
    constexpr std::array<std::string_view, 3> kNames{"error", "warning", "note"};
    std::string text(kNames[static_cast<std::size_t>(finding.severity)]);
    text += ": " + finding.where + ": " + finding.what;
    return finding.remedy.empty() ? text : text + "; " + finding.remedy;
}

} // namespace springdrive::study
