#include "engine/session/model_measurement.h"

#include "engine/lab/model_selection/selection_cache.h"

#include <cmath>
#include <exception>
#include <utility>

namespace springdrive::session {

namespace {

std::string text_of(const std::string &what, double share) {
    return what + ", " + std::to_string(std::lround(100.0 * share)) + " %";
}

std::string key_of(const model_selection::ModelQuestion &question, const ModelMemory &memory) {
    return model_selection::model_selection_key(question, memory.device_text,
                                                memory.program_version);
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

std::optional<model_selection::ModelSelection>
stored_selection(const model_selection::ModelQuestion &question, const ModelMemory &memory) {
    return model_selection::read_model_selection(model_selection::model_cache_folder(),
                                                 key_of(question, memory));
}

model_selection::ModelSelection measured_selection(const model_selection::ModelQuestion &question,
                                                   const ModelMemory &memory,
                                                   const model_selection::ModelProgress &progress) {
    model_selection::ModelSelection choice =
        model_selection::choose_scene_model(question, progress);
    model_selection::write_model_selection(model_selection::model_cache_folder(),
                                           key_of(question, memory), choice);
    return choice;
}

model_selection::ModelSelection known_selection(const model_selection::ModelQuestion &question,
                                                const ModelMemory &memory,
                                                const model_selection::ModelProgress &progress) {
    if (std::optional<model_selection::ModelSelection> choice =
            stored_selection(question, memory)) {
        return *std::move(choice);
    }
    return measured_selection(question, memory, progress);
}

void ModelMeasurement::begin(const model_selection::ModelQuestion &question,
                             const ModelMemory &memory) {
    discard();
    error_.clear();
    measuring_.start(
        [question, memory, scene = without_looks(*question.scene)](BackgroundTalk &talk) {
            model_selection::ModelQuestion own = question;
            own.scene = &scene;
            return measured_selection(own, memory, [&talk](const std::string &what, double share) {
                talk.report(what, share);
            });
        });
}

std::string ModelMeasurement::progress() const {
    return text_of(measuring_.what(), measuring_.share());
}

std::optional<model_selection::ModelSelection> ModelMeasurement::take() {
    try {
        return measuring_.take();
    } catch (const std::exception &error) {
        error_ = error.what();
        return std::nullopt;
    }
}

} // namespace springdrive::session
