// Real models for tests, from the folder that the environment's MVW_MODELS names.
#pragma once
#include <gtest/gtest.h>

#include <string>

#include "codec/bytes.h"
#include "codec/mesh/clean.h"
#include "codec/mesh/mesh.h"
#include "codec/result.h"

/// Skips the test where there are no models.
#define MVW_SKIP_WITHOUT_MODELS() \
    if (mvw::models_folder().empty()) GTEST_SKIP() << "MVW_MODELS is not set"

namespace mvw {

/// What MVW_MODELS says, without a slash at its end; empty where it is not set.
std::string models_folder();

/// The bytes of models_folder()/name, unpacked where the file is there as name.zst or the name itself ends so.
Result<Bytes> model_bytes(const std::string& name);

/// Reads a model as its file states it. `name` is relative to the folder ("bob.obj", "dragon.ply", "tiny/tetra.off"),
/// with or without .zst.
Result<Mesh> read_model(const std::string& name, CleanReport& report);

/// A model read and cleaned; an empty mesh and a failed test where that does not work.
Mesh clean_model(const std::string& name);

}  // namespace mvw
