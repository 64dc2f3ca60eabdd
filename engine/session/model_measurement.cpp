#include "engine/session/model_measurement.h"

#include "engine/model_choice/choice_cache.h"

#include <cmath>
#include <exception>
#include <utility>

namespace springdrive {

namespace {

std::string text_of(const std::string &what, double share) {
    return what + ", " + std::to_string(std::lround(100.0 * share)) + " %";
}

std::string key_of(const ModelQuestion &question, const ModelMemory &memory) {
    return model_choice_key(question, memory.device_text, memory.program_version);
}

} // namespace

Scene without_looks(const Scene &scene) {
    Scene bare;
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

std::optional<ModelChoice> remembered_choice(const ModelQuestion &question,
                                             const ModelMemory &memory) {
    return read_model_choice(model_cache_folder(), key_of(question, memory));
}

ModelChoice measured_choice(const ModelQuestion &question, const ModelMemory &memory,
                            const ModelProgress &progress) {
    ModelChoice choice = choose_scene_model(question, progress);
    write_model_choice(model_cache_folder(), key_of(question, memory), choice);
    return choice;
}

ModelChoice known_choice(const ModelQuestion &question, const ModelMemory &memory,
                         const ModelProgress &progress) {
    if (std::optional<ModelChoice> choice = remembered_choice(question, memory)) {
        return *std::move(choice);
    }
    return measured_choice(question, memory, progress);
}

void ModelMeasurement::begin(const ModelQuestion &question, const ModelMemory &memory) {
    forget();
    error_.clear();
    measuring_.start(
        [question, memory, scene = without_looks(*question.scene)](BackgroundTalk &talk) {
            ModelQuestion own = question;
            own.scene = &scene;
            return measured_choice(own, memory, [&talk](const std::string &what, double share) {
                talk.tell(what, share);
            });
        });
}

std::string ModelMeasurement::progress() const {
    return text_of(measuring_.what(), measuring_.share());
}

std::optional<ModelChoice> ModelMeasurement::take() {
    try {
        return measuring_.take();
    } catch (const std::exception &error) {
        error_ = error.what();
        return std::nullopt;
    }
}

} // namespace springdrive
