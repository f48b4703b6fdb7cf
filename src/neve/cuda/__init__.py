"""The stages of the step on a GPU of NVIDIA.

`driver` calls the driver library, `program` compiles the kernels of `core/cuda` at their first use, `layout`
is what both sides know of each other's memory; `model`, `state` and `grid` are the objects of a run, and
`stages` what is done with them: the same as `neve._core.f32` and `neve._core.f64` do on the processor.
"""
