#include "engine/session/scene_loader.h"

#include "base/wanted.h"
#include "engine/contact/preparation/mesh_remarks.h"
#include "engine/scene/gltf.h"
#include "engine/servo/record/file_hash.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <utility>

namespace springdrive {

std::unique_ptr<LoadedScene> load_scene(const std::filesystem::path &file,
                                        const Workspace &workspace, LoadProgress &progress) {
    const GivenUpBy given_up(&progress.is_given_up());
    Scene scene = load_gltf(file, workspace, &progress);
    progress.begin(LoadProgress::Stage::preparing, false);
    HapticSurface surface(scene.surface, scene.shapes);
    std::ranges::move(remarks_on(surface.report(), scene.surface.materials),
                      std::back_inserter(scene.remarks));
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
    progress_ = std::make_shared<LoadProgress>();
    loading_.start(
        [file, finish, workspace = workspace_, progress = progress_](BackgroundTalk &talk) {
            std::unique_ptr<LoadedScene> loaded = load_scene(file, workspace, *progress);
            if (finish) {
                const GivenUpBy given_up(&progress->is_given_up());
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

} // namespace springdrive
