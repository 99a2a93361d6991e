// Which parts of Draco the module carries: triangle meshes with integer positions, as FORMAT.md 4.1 has them.
#pragma once
#define DRACO_MESH_COMPRESSION_SUPPORTED
#define DRACO_STANDARD_EDGEBREAKER_SUPPORTED
