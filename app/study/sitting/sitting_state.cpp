#include "app/study/sitting/sitting_state.h"

namespace springdrive::app::study_screen {

std::string_view description(SittingStep step) {
    switch (step) {
    case SittingStep::questionnaire:
        return "answers the questionnaire";
    case SittingStep::noise_check:
        return "listens to the noise";
    case SittingStep::instructions:
        return "reads the instructions";
    case SittingStep::warming_up:
        return "waits until the windings are warm, or cool, enough";
    case SittingStep::practice_begins:
        return "is told that the practice begins";
    case SittingStep::practice_ends:
        return "is told that it counts from now on";
    case SittingStep::block_begins:
        return "is told that a new part begins";
    case SittingStep::in_break:
        return "has a break";
    case SittingStep::paused:
        return "waits: paused";
    case SittingStep::setting_up:
        return "waits for the scene";
    case SittingStep::device_lost:
        return "waits for the device, which is not connected or not zeroed";
    case SittingStep::device_stopped:
        return "waits for the device, which was stopped";
    case SittingStep::interval:
        return "feels";
    case SittingStep::between_intervals:
        return "waits for the next interval";
    case SittingStep::response:
        return "is asked";
    case SittingStep::after_response:
        return "has answered";
    case SittingStep::over:
        break;
    }
    return "is through";
}

std::string_view description(study::StimulusPhase phase) {
    switch (phase) {
    case study::StimulusPhase::waiting:
        return "the hand comes to rest above the spot";
    case study::StimulusPhase::approaching:
        return "the hand approaches";
    case study::StimulusPhase::presenting:
        return "the stimulus is presented";
    case study::StimulusPhase::gliding_back:
        return "the gains glide back";
    case study::StimulusPhase::leaving:
        return "the hand leaves";
    case study::StimulusPhase::failed:
        return "it was broken off";
    case study::StimulusPhase::done:
        break;
    }
    return "it is over";
}

} // namespace springdrive::app::study_screen
