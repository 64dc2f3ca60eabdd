#include "engine/session/scene_loader.h"

#include "base/cancellation.h"
#include "base/sha256.h"
#include "engine/contact/mesh/mesh_warnings.h"
#include "engine/scene/gltf.h"
#include "engine/scene/scene.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <utility>

namespace springdrive::session {

std::unique_ptr<LoadedScene> load_scene(const std::filesystem::path &file,
                                        const device::Workspace &workspace,
                                        scene::LoadProgress &progress) {
    const StopScope given_up(&progress.is_cancelled());
    scene::Scene scene = scene::load_gltf(file, workspace, &progress);
    progress.begin(scene::LoadProgress::Stage::preparing, false);
    contact::HapticSurface surface = scene::haptic_surface_of(scene);
    std::ranges::move(contact::warnings_about(surface.report(), scene.surface.materials),
                      std::back_inserter(scene.warnings));
    return std::make_unique<LoadedScene>(
        LoadedScene{std::move(scene), std::move(surface), sha256_of_file(file)});
}

void SceneLoader::request(const std::filesystem::path &file, const Finish &finish) {
    if (is_loading()) {
        next_ = Request{file, finish};
        loading_.ask_to_end();
        progress_->give_up();
        return;
    }
    error_.clear();
    progress_ = std::make_shared<scene::LoadProgress>();
    loading_.start(
        [file, finish, workspace = workspace_, progress = progress_](BackgroundTalk &talk) {
            std::unique_ptr<LoadedScene> loaded = load_scene(file, workspace, *progress);
            if (finish) {
                const StopScope given_up(&progress->is_cancelled());
                finish(*loaded, *progress, talk);
            }
            return loaded;
        });
}

std::unique_ptr<LoadedScene> SceneLoader::take() {
    std::unique_ptr<LoadedScene> scene;
    try {
        scene = loading_.take().value_or(nullptr);
    } catch (const std::exception &error) {
        error_ = error.what();
    }
    if (next_ && !is_loading()) {
        const Request next = *std::exchange(next_, std::nullopt);
        request(next.file, next.finish);
    }
    return scene;
}

Scenes::Scenes(const device::Workspace &workspace, std::unique_ptr<LoadedScene> first)
    : now_(std::move(first)), loader_(workspace) {}

void Scenes::request(const std::filesystem::path &file, const SceneLoader::Finish &finish) {
    loader_.request(file, finish);
}

const LoadedScene *Scenes::take_loaded() {
    std::unique_ptr<LoadedScene> loaded = loader_.take();
    if (!loaded) {
        return nullptr;
    }
    retired_.push_back(std::exchange(now_, std::move(loaded)));
    ++id_;
    return retired_.back().get();
}

void Scenes::note_in_use(std::uint32_t id) {
    if (id != id_) {
        return;
    }
    for (std::unique_ptr<LoadedScene> &scene : std::exchange(retired_, {})) {
        release_.let_go(std::move(scene));
    }
}

} // namespace springdrive::session
