#include "engine/session/model_measurement.h"

#include "engine/lab/model_selection/choice_cache.h"

#include <cmath>
#include <exception>
#include <utility>

namespace springdrive::session {

namespace {

std::string text_of(const std::string &what, double share) {
    return what + ", " + std::to_string(std::lround(100.0 * share)) + " %";
}

std::string key_of(const model_selection::ModelQuestion &question, const ModelMemory &memory) {
    return model_selection::model_choice_key(question, memory.device_text, memory.program_version);
}

} // namespace

scene::Scene without_looks(const scene::Scene &scene) {
    scene::Scene bare;
    bare.file = scene.file;
    bare.surface = scene.surface;
    bare.flat_surface = scene.flat_surface;
    bare.shapes = scene.shapes;
    bare.lower_m = scene.lower_m;
    bare.upper_m = scene.upper_m;
    bare.metres_per_unit = scene.metres_per_unit;
    bare.in_metres = scene.in_metres;
    bare.planar = scene.planar;
    bare.tolerance = scene.tolerance;
    return bare;
}

std::optional<model_selection::ModelChoice>
remembered_choice(const model_selection::ModelQuestion &question, const ModelMemory &memory) {
    return model_selection::read_model_choice(model_selection::model_cache_folder(),
                                              key_of(question, memory));
}

model_selection::ModelChoice measured_choice(const model_selection::ModelQuestion &question,
                                             const ModelMemory &memory,
                                             const model_selection::ModelProgress &progress) {
    model_selection::ModelChoice choice = model_selection::choose_scene_model(question, progress);
    model_selection::write_model_choice(model_selection::model_cache_folder(),
                                        key_of(question, memory), choice);
    return choice;
}

model_selection::ModelChoice known_choice(const model_selection::ModelQuestion &question,
                                          const ModelMemory &memory,
                                          const model_selection::ModelProgress &progress) {
    if (std::optional<model_selection::ModelChoice> choice = remembered_choice(question, memory)) {
        return *std::move(choice);
    }
    return measured_choice(question, memory, progress);
}

void ModelMeasurement::begin(const model_selection::ModelQuestion &question,
                             const ModelMemory &memory) {
    forget();
    error_.clear();
    measuring_.start(
        [question, memory, scene = without_looks(*question.scene)](BackgroundTalk &talk) {
            model_selection::ModelQuestion own = question;
            own.scene = &scene;
            return measured_choice(own, memory, [&talk](const std::string &what, double share) {
                talk.tell(what, share);
            });
        });
}

std::string ModelMeasurement::progress() const {
    return text_of(measuring_.what(), measuring_.share());
}

std::optional<model_selection::ModelChoice> ModelMeasurement::take() {
    try {
        return measuring_.take();
    } catch (const std::exception &error) {
        error_ = error.what();
        return std::nullopt;
    }
}

} // namespace springdrive::session
