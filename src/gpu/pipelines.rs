//! Render pipelines of `shaders/scene.wgsl`, one set per sample count.

use super::cutter_caps::CutterCap;
use super::cutters::{CutterInstance, UnitVertex};
use super::mesh::{Segment, Vertex};
use super::scene::SurfaceInstance;

/// Format of the picture: gamma-encoded, opaque.
pub const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of the ids for picking.
pub const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Format of the depth buffer; the stencil marks where the section plane cuts material.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth24PlusStencil8;
/// Source of the scene shader.
pub const SCENE_WGSL: &str = include_str!("../../shaders/scene.wgsl");

/// All render pipelines for one sample count.
#[derive(Debug)]
pub struct Pipelines {
    pub background: wgpu::RenderPipeline,
    pub surface: wgpu::RenderPipeline,
    pub floor: wgpu::RenderPipeline,
    /// The floor with heights from a buffer of their own, and with the difference of two such buffers.
    pub stock: wgpu::RenderPipeline,
    pub difference: wgpu::RenderPipeline,
    /// The stock as a solid, its parity, and the section plane where it cuts stock beside the part.
    pub solid: wgpu::RenderPipeline,
    pub solid_parity: wgpu::RenderPipeline,
    pub solid_cap: wgpu::RenderPipeline,
    pub glass: wgpu::RenderPipeline,
    pub cutter: wgpu::RenderPipeline,
    pub cutter_glass: wgpu::RenderPipeline,
    /// The section plane where it cuts tools.
    pub cutter_cap: wgpu::RenderPipeline,
    pub line: wgpu::RenderPipeline,
    /// Invert one stencil bit per face: of the hub, of the blades.
    pub parity: [wgpu::RenderPipeline; 2],
    /// Draws the section plane where the stencil marks material.
    pub cap: wgpu::RenderPipeline,
    /// Pipelines that draw ids into [`ID_FORMAT`]; only with one sample per pixel.
    pub ids: Option<IdPipelines>,
}

/// Pipelines that draw ids: cutters write theirs, everything else only occludes.
#[derive(Debug)]
pub struct IdPipelines {
    pub surface: wgpu::RenderPipeline,
    pub values: wgpu::RenderPipeline,
    pub solid: wgpu::RenderPipeline,
    pub parity: [wgpu::RenderPipeline; 2],
    pub cap: wgpu::RenderPipeline,
    pub cutter: wgpu::RenderPipeline,
}

/// Stencil bits of hub and blades, and of the stock as a solid.
const PART_BITS: u32 = 3;
const SOLID_BIT: u32 = 4;

/// Use of the stencil by a pipeline.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stencil {
    /// Not used.
    Ignored,
    /// Inverts these bits and draws no colour.
    Inverted(u32),
    /// Draws only where any of these bits is set.
    Masked(u32),
}

impl Stencil {
    fn state(self) -> wgpu::StencilState {
        let face = |compare, pass_op| wgpu::StencilFaceState {
            compare,
            fail_op: wgpu::StencilOperation::Keep,
            depth_fail_op: wgpu::StencilOperation::Keep,
            pass_op,
        };
        let both =
            |face, write_mask| wgpu::StencilState { front: face, back: face, read_mask: !0, write_mask };
        match self {
            Self::Ignored => wgpu::StencilState::default(),
            Self::Inverted(bits) => {
                both(face(wgpu::CompareFunction::Always, wgpu::StencilOperation::Invert), bits)
            }
            Self::Masked(bits) => wgpu::StencilState {
                read_mask: bits,
                ..both(face(wgpu::CompareFunction::NotEqual, wgpu::StencilOperation::Keep), 0)
            },
        }
    }
}

/// The settings in which the pipelines differ.
struct PipelineSpec<'a> {
    label: &'a str,
    vertex: &'a str,
    fragment: &'a str,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    glass: bool,
    behind_all: bool,
    /// Whether it draws a strip of triangles.
    strip: bool,
    stencil: Stencil,
    format: wgpu::TextureFormat,
}

impl Pipelines {
    /// Builds all pipelines; `layout` has the frame uniform as group 0.
    pub fn new(
        device: &wgpu::Device,
        module: &wgpu::ShaderModule,
        layout: &wgpu::PipelineLayout,
        samples: u32,
    ) -> Self {
        let corner = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x3, 3 => Float32];
        let turn = wgpu::vertex_attr_array![4 => Float32x2, 5 => Uint32, 6 => Uint32];
        let unit = wgpu::vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Uint32];
        let cutter = wgpu::vertex_attr_array![
            3 => Float32x3, 4 => Float32, 5 => Float32x3, 6 => Float32,
            7 => Float32, 8 => Float32, 9 => Uint32, 10 => Uint32];
        let cap = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x3, 3 => Float32,
            4 => Float32x2, 5 => Float32, 6 => Float32, 7 => Uint32];
        let segment = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x3, 3 => Uint32];
        let surfaces = [
            buffer::<Vertex>(wgpu::VertexStepMode::Vertex, &corner),
            buffer::<SurfaceInstance>(wgpu::VertexStepMode::Instance, &turn),
        ];
        let (height, less) = (wgpu::vertex_attr_array![7 => Float32], wgpu::vertex_attr_array![8 => Float32]);
        let [corners, turns] = surfaces.clone();
        let stock = [
            corners,
            turns,
            buffer::<f32>(wgpu::VertexStepMode::Vertex, &height),
            buffer::<f32>(wgpu::VertexStepMode::Vertex, &less),
        ];
        let painted = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x3, 3 => Uint32];
        let solid = [buffer::<Vertex>(wgpu::VertexStepMode::Vertex, &painted)];
        let cutters = [
            buffer::<UnitVertex>(wgpu::VertexStepMode::Vertex, &unit),
            buffer::<CutterInstance>(wgpu::VertexStepMode::Instance, &cutter),
        ];
        let caps = [buffer::<CutterCap>(wgpu::VertexStepMode::Instance, &cap)];
        let lines = [buffer::<Segment>(wgpu::VertexStepMode::Instance, &segment)];
        let build = |stage: &PipelineSpec| pipeline(device, module, layout, samples, stage);
        let stage = |label, vertex, fragment, buffers, glass| PipelineSpec {
            label,
            vertex,
            fragment,
            buffers,
            glass,
            behind_all: false,
            strip: false,
            stencil: Stencil::Ignored,
            format: COLOUR_FORMAT,
        };
        let id = |label, vertex, fragment, buffers| PipelineSpec {
            format: ID_FORMAT,
            ..stage(label, vertex, fragment, buffers, false)
        };
        let parity = |label, format| {
            let turned = |bit| PipelineSpec {
                format,
                stencil: Stencil::Inverted(bit),
                ..stage(label, "surface_vertex", "parity_fragment", &surfaces, false)
            };
            [1, 2].map(|bit| build(&turned(bit)))
        };
        let ids = (samples == 1).then(|| IdPipelines {
            surface: build(&id("surface ids", "surface_vertex", "surface_id_fragment", &surfaces)),
            values: build(&id("value ids", "floor_vertex", "values_id_fragment", &surfaces)),
            solid: build(&id("solid ids", "solid_vertex", "solid_id_fragment", &solid)),
            parity: parity("parity of ids", ID_FORMAT),
            cap: build(&PipelineSpec {
                strip: true,
                stencil: Stencil::Masked(PART_BITS),
                ..id("cap ids", "cap_vertex", "cap_id_fragment", &[])
            }),
            cutter: build(&id("cutter ids", "cutter_vertex", "cutter_id_fragment", &cutters)),
        });
        Self {
            ids,
            background: build(&PipelineSpec {
                behind_all: true,
                ..stage("background", "background_vertex", "background_fragment", &[], false)
            }),
            surface: build(&stage("surface", "surface_vertex", "surface_fragment", &surfaces, false)),
            floor: build(&stage("floor", "floor_vertex", "floor_fragment", &surfaces, false)),
            stock: build(&stage("stock", "stock_vertex", "floor_fragment", &stock[..3], false)),
            difference: build(&stage("difference", "difference_vertex", "floor_fragment", &stock, false)),
            solid: build(&stage("solid", "solid_vertex", "solid_fragment", &solid, false)),
            solid_parity: build(&PipelineSpec {
                stencil: Stencil::Inverted(SOLID_BIT),
                ..stage("solid parity", "solid_vertex", "solid_parity_fragment", &solid, false)
            }),
            solid_cap: build(&PipelineSpec {
                strip: true,
                stencil: Stencil::Masked(SOLID_BIT),
                ..stage("solid cap", "cap_vertex", "solid_cap_fragment", &[], false)
            }),
            glass: build(&stage("glass", "surface_vertex", "glass_fragment", &surfaces, true)),
            cutter: build(&stage("cutter", "cutter_vertex", "cutter_fragment", &cutters, false)),
            cutter_glass: build(&stage(
                "cutter glass",
                "cutter_vertex",
                "cutter_glass_fragment",
                &cutters,
                true,
            )),
            cutter_cap: build(&PipelineSpec {
                strip: true,
                ..stage("cutter cap", "cutter_cap_vertex", "cutter_cap_fragment", &caps, false)
            }),
            parity: parity("parity", COLOUR_FORMAT),
            cap: build(&PipelineSpec {
                strip: true,
                stencil: Stencil::Masked(PART_BITS),
                ..stage("cap", "cap_vertex", "cap_fragment", &[], false)
            }),
            line: build(&stage("line", "line_vertex", "line_fragment", &lines, false)),
        }
    }
}

fn buffer<T>(
    step_mode: wgpu::VertexStepMode,
    attributes: &[wgpu::VertexAttribute],
) -> Option<wgpu::VertexBufferLayout<'_>> {
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<T>() as wgpu::BufferAddress,
        step_mode,
        attributes,
    })
}

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    samples: u32,
    stage: &PipelineSpec,
) -> wgpu::RenderPipeline {
    let counts = matches!(stage.stencil, Stencil::Inverted(_));
    let blend = wgpu::BlendState {
        color: wgpu::BlendState::ALPHA_BLENDING.color,
        // Alpha of 1 stays 1, so the picture stays opaque.
        alpha: wgpu::BlendComponent::OVER,
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(stage.label),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(stage.vertex),
            compilation_options: Default::default(),
            buffers: stage.buffers,
        },
        // No culling: the winding of blades depends on the part file, so the shader uses the normals.
        primitive: wgpu::PrimitiveState {
            topology: match stage.strip {
                true => wgpu::PrimitiveTopology::TriangleStrip,
                false => wgpu::PrimitiveTopology::TriangleList,
            },
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(!stage.glass && !stage.behind_all && !counts),
            depth_compare: Some(if stage.behind_all || counts {
                wgpu::CompareFunction::Always
            } else {
                wgpu::CompareFunction::Less
            }),
            stencil: stage.stencil.state(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(stage.fragment),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: stage.format,
                blend: stage.glass.then_some(blend),
                write_mask: if counts { wgpu::ColorWrites::empty() } else { wgpu::ColorWrites::ALL },
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use super::SCENE_WGSL;

    #[test]
    fn the_shader_is_valid() {
        let module = naga::front::wgsl::parse_str(SCENE_WGSL).expect("parses");
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
            .validate(&module)
            .expect("validates without optional capabilities");
    }
}
