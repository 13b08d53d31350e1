//! Draws a [`Scene`] into a texture. The window shows the texture and the command line reads it back, so that
//! both get the same pixels.

use std::ops::Range;

use bytemuck::Pod;
use glam::{UVec2, Vec2, Vec3};

use super::camera::Camera;
use super::cutters::{self, CutterInstance, DrawnChannel, UnitCutter};
use super::device::{Gpu, GpuError};
use super::drawn_cutters::DrawnCutters;
use super::mesh_buffers::{MeshBuffers, index_buffer, vertex_buffer};
use super::pick::{self, PickTarget};
use super::pipelines::{COLOUR_FORMAT, DEPTH_FORMAT, Pipelines, SCENE_WGSL};
use super::scene::{DrawGroup, FloorColours, Scene, SceneOptions};
use super::surfaces::{
    draw_part, draw_section_cap, draw_solid, draw_solid_cap, draw_surfaces, draw_values, is_opaque,
};
use super::target;
use super::uniform::FrameUniform;

/// Facets of a cutter, in still pictures and in motion.
const FACETS: usize = 24;
const DRAFT_FACETS: usize = 10;

/// A picture in memory: 8-bit RGBA, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// 4 · width · height bytes.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// A row of pixels, counted from the top.
    fn row(&self, y: u32) -> &[u8] {
        let bytes = 4 * self.width as usize;
        &self.rgba[y as usize * bytes..][..bytes]
    }

    /// Some of its columns.
    pub fn columns(&self, columns: Range<u32>) -> Self {
        let bytes = 4 * columns.start as usize..4 * columns.end as usize;
        let rgba = (0..self.height).flat_map(|y| &self.row(y)[bytes.clone()]).copied().collect();
        Self { width: columns.end - columns.start, height: self.height, rgba }
    }

    /// Two pictures of one height beside each other.
    pub fn beside(left: &Self, right: &Self) -> Self {
        let rgba = (0..left.height).flat_map(|y| left.row(y).iter().chain(right.row(y))).copied().collect();
        Self { width: left.width + right.width, height: left.height, rgba }
    }
}

/// Render target of one size and sample count.
#[derive(Debug)]
struct Target {
    size: UVec2,
    samples: u32,
    colour: wgpu::Texture,
    view: wgpu::TextureView,
    multisampled: Option<wgpu::TextureView>,
    depth: wgpu::TextureView,
}

/// A vertex buffer that is rewritten for every picture and grows when needed.
#[derive(Debug)]
struct GrowingBuffer {
    label: &'static str,
    buffer: Option<wgpu::Buffer>,
    count: u32,
}

impl GrowingBuffer {
    fn new(label: &'static str) -> Self {
        Self { label, buffer: None, count: 0 }
    }

    fn write<T: Pod>(&mut self, gpu: &Gpu, contents: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        self.count = contents.len() as u32;
        if bytes.is_empty() {
            return;
        }
        let size = bytes.len() as u64;
        if self.buffer.as_ref().is_none_or(|b| b.size() < size) {
            self.buffer = Some(gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(self.label),
                size: size.next_power_of_two(),
                usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }));
        }
        if let Some(buffer) = &self.buffer {
            gpu.queue.write_buffer(buffer, 0, bytes);
        }
    }
}

/// Size of a picture in motion instead of `size`: on a software driver a sixth of the pixels, else the same.
pub fn draft_size(gpu: &Gpu, size: UVec2) -> UVec2 {
    if gpu.is_software() { (size * 2 / 5).max(UVec2::ONE) } else { size }
}

/// The mesh of which every cutter is an instance; its first `solid` indices are opaque.
#[derive(Debug)]
struct CutterMesh {
    mesh: MeshBuffers,
    solid: u32,
}

/// Draws scenes; keeps pipelines and render target between pictures.
#[derive(Debug)]
pub struct Renderer {
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    /// Pipelines for one sample per pixel and for four, each built on first use.
    pipelines: [Option<Pipelines>; 2],
    uniform: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    /// The mesh of which every cutter is an instance: fine, and for pictures in motion.
    cutter_meshes: [CutterMesh; 2],
    cutters: GrowingBuffer,
    /// What the section plane cuts of them.
    cutter_caps: GrowingBuffer,
    cutter_lines: GrowingBuffer,
    target: Option<Target>,
    pick_target: PickTarget,
    generation: u64,
}

/// A size that the device can draw.
fn clamped(gpu: &Gpu, size: UVec2) -> UVec2 {
    size.clamp(UVec2::ONE, UVec2::splat(gpu.device.limits().max_texture_dimension_2d))
}

impl Renderer {
    /// Prepares a renderer on a device.
    pub fn new(gpu: &Gpu) -> Self {
        let device = &gpu.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("scene"),
            source: wgpu::ShaderSource::Wgsl(SCENE_WGSL.into()),
        });
        let group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("scene"),
            bind_group_layouts: &[Some(&group_layout)],
            immediate_size: 0,
        });
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<FrameUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &group_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        let units = [FACETS, DRAFT_FACETS].map(|facets| {
            let UnitCutter { vertices, indices, solid } = UnitCutter::new(facets);
            let mesh = MeshBuffers {
                vertices: vertex_buffer(gpu, "unit cutter", &vertices),
                indices: index_buffer(gpu, "unit cutter triangles", &indices),
                count: indices.len() as u32,
            };
            CutterMesh { mesh, solid }
        });
        Self {
            module,
            layout,
            pipelines: [None, None],
            uniform,
            bind_group,
            cutter_meshes: units,
            cutters: GrowingBuffer::new("cutters"),
            cutter_caps: GrowingBuffer::new("cutter caps"),
            cutter_lines: GrowingBuffer::new("cutter lines"),
            target: None,
            pick_target: PickTarget::new(device),
            generation: 0,
        }
    }

    /// Draws a picture of `size` pixels, clamped to 1 × 1 and to the limit of the device, with 4 samples per
    /// pixel, or 1 if `samples` < 4 (in motion).
    pub fn render(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        camera: &Camera,
        options: &SceneOptions,
        size: UVec2,
        samples: u32,
    ) {
        let size = clamped(gpu, size);
        let samples = if samples >= 4 { 4 } else { 1 };
        self.ensure_target(gpu, size, samples);
        let set = usize::from(samples == 4);
        self.ensure_pipelines(gpu, samples);
        let camera = &scene.enclosing(camera, options);
        let uniform = FrameUniform::new(scene.framing(), camera, options, size);
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        self.stream_cutters(gpu, scene, &scene.channels, camera, options);
        let (Some(target), Some(pipelines)) = (&self.target, &self.pipelines[set]) else { return };

        let (view, resolved) = match &target.multisampled {
            Some(view) => (view, Some(&target.view)),
            None => (&target.view, None),
        };
        target::run_render_pass(gpu, "scene", view, resolved, &target.depth, |pass| {
            pass.set_bind_group(0, &self.bind_group, &[]);
            self.draw(pass, pipelines, scene, options);
        });
    }

    /// Draws opaque surfaces first, then transparent ones from the inside out: walls, cutters, shroud.
    fn draw(
        &self,
        pass: &mut wgpu::RenderPass,
        pipelines: &Pipelines,
        scene: &Scene,
        options: &SceneOptions,
    ) {
        if !options.transparent {
            pass.set_pipeline(&pipelines.background);
            pass.draw(0..3, 0..1);
        }

        let wheel = scene.wheel(options);
        let body = scene.solid(options);
        match body {
            Some(solid) => {
                pass.set_pipeline(&pipelines.solid);
                draw_solid(pass, solid);
            }
            None => draw_part(pass, pipelines, scene, options),
        }
        match body {
            Some(solid) => draw_solid_cap(pass, wheel, options, pipelines, solid),
            None => draw_section_cap(pass, wheel, options, &pipelines.parity, &pipelines.cap),
        }
        if let Some(machine) = scene.machine(options) {
            pass.set_pipeline(&pipelines.solid);
            draw_solid(pass, machine);
        }
        let unit = self.cutter_mesh(options);
        let solid = 0..unit.solid;
        // Overdraw of transparent walls is the main cost, so in motion only the cutters' bottoms are drawn.
        let glass = unit.solid..if options.draft { unit.solid * 4 / 3 } else { unit.mesh.count };
        pass.set_pipeline(&pipelines.cutter);
        self.draw_cutters(pass, unit, solid);
        if let Some(buffer) = self.cutter_caps.buffer.as_ref().filter(|_| self.cutter_caps.count > 0) {
            pass.set_pipeline(&pipelines.cutter_cap);
            pass.set_vertex_buffer(0, buffer.slice(..));
            pass.draw(0..4, 0..self.cutter_caps.count);
        }

        pass.set_pipeline(&pipelines.line);
        if options.show_blades && body.is_none() && wheel.edge_count > 0 {
            pass.set_vertex_buffer(0, wheel.edges.slice(..));
            pass.draw(0..6, 0..wheel.edge_count);
        }
        let borders = scene.borders.as_ref().filter(|_| options.show_borders && body.is_none());
        for (buffer, count) in scene.paths.iter().chain(borders) {
            pass.set_vertex_buffer(0, buffer.slice(..));
            pass.draw(0..6, 0..*count);
        }
        if let Some(buffer) = self.cutter_lines.buffer.as_ref().filter(|_| self.cutter_lines.count > 0) {
            pass.set_vertex_buffer(0, buffer.slice(..));
            pass.draw(0..6, 0..self.cutter_lines.count);
        }

        pass.set_pipeline(&pipelines.glass);
        draw_surfaces(pass, wheel, &|layer| {
            layer == DrawGroup::CutAway && options.show_blades && options.cut_away && body.is_none()
        });
        pass.set_pipeline(&pipelines.cutter_glass);
        self.draw_cutters(pass, unit, glass);
        pass.set_pipeline(&pipelines.glass);
        draw_surfaces(pass, wheel, &|layer| layer == DrawGroup::Shroud && options.show_shroud);
    }

    fn cutter_mesh(&self, options: &SceneOptions) -> &CutterMesh {
        &self.cutter_meshes[usize::from(options.draft)]
    }

    fn draw_cutters(&self, pass: &mut wgpu::RenderPass, unit: &CutterMesh, indices: Range<u32>) {
        if let Some(buffer) = self.cutters.buffer.as_ref().filter(|_| self.cutters.count > 0) {
            pass.set_vertex_buffer(0, unit.mesh.vertices.slice(..));
            pass.set_vertex_buffer(1, buffer.slice(..));
            pass.set_index_buffer(unit.mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(indices, 0, 0..self.cutters.count);
        }
    }

    /// Position whose cutter is under a pixel of a picture of `size`, or within [`pick::PICK_RADIUS`] pixels
    /// of it; `None` if there is none or the part hides it. Ids are drawn on the device, so that
    /// transparency, section plane and layers count as drawn.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when the device fails.
    pub fn pick(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        camera: &Camera,
        options: &SceneOptions,
        pixel: Vec2,
        size: Vec2,
    ) -> Result<Option<usize>, GpuError> {
        self.ensure_pipelines(gpu, 1);
        let seen = FrameUniform::new(scene.framing(), camera, options, size.as_uvec2().max(UVec2::ONE));
        let seen = seen.cropped_about(pixel, size, pick::WINDOW as f32);
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&seen));
        self.stream_cutters(gpu, scene, &[], camera, options);
        let Some(ids) = self.pipelines[0].as_ref().and_then(|p| p.ids.as_ref()) else {
            return Ok(None);
        };
        // Cutters of a plan preview cannot be picked.
        if scene.preview.is_some() {
            return Ok(None);
        }
        let target = &self.pick_target;
        let draw = |pass: &mut wgpu::RenderPass| {
            let wheel = scene.wheel(options);
            pass.set_bind_group(0, &self.bind_group, &[]);
            if let Some(solid) = scene.solid(options) {
                pass.set_pipeline(&ids.solid);
                draw_solid(pass, solid);
                pass.set_pipeline(&ids.cutter);
                self.draw_cutters(pass, self.cutter_mesh(options), 0..self.cutter_mesh(options).mesh.count);
                return;
            }
            pass.set_pipeline(&ids.surface);
            draw_surfaces(pass, wheel, &|layer| is_opaque(layer, options));
            let walls = scene.floor.as_ref().filter(|_| options.show_floor_colours == FloorColours::Walls);
            if let Some(walls) = walls {
                pass.set_pipeline(&ids.values);
                draw_values(pass, wheel, &walls.residual);
            }
            draw_section_cap(pass, wheel, options, &ids.parity, &ids.cap);
            pass.set_pipeline(&ids.cutter);
            self.draw_cutters(pass, self.cutter_mesh(options), 0..self.cutter_mesh(options).mesh.count);
        };
        target.draw(gpu, draw);
        Ok(target.nearest(gpu)?.map(|id| id as usize))
    }

    fn ensure_pipelines(&mut self, gpu: &Gpu, samples: u32) {
        let set = usize::from(samples == 4);
        if self.pipelines[set].is_none() {
            self.pipelines[set] = Some(Pipelines::new(&gpu.device, &self.module, &self.layout, samples));
        }
    }

    /// Uploads the cutters to draw, those of `channels` too, sorted from far to near as alpha blending
    /// requires, and their lines.
    fn stream_cutters(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        channels: &[DrawnChannel],
        camera: &Camera,
        options: &SceneOptions,
    ) {
        let mut choice = options.cutter_choice();
        let mut channels = channels.to_vec();
        if scene.preview.is_some() {
            // Selection and timeline refer to the previous plan.
            (choice.up_to, choice.selected) = (None, None);
            channels.iter_mut().for_each(|channel| channel.up_to = None);
        }
        let cutters = scene.preview.as_deref().unwrap_or(&scene.cutters);
        let mut drawn = DrawnCutters::default();
        let steps = if cutters.len() > 300 { 16 } else { 32 };
        for cutter in cutters {
            // In motion only the selected and the last cutter get rims.
            drawn.add(cutter, &choice, options, steps, !options.draft);
        }
        for channel in &channels {
            let (choice, turn) = (channel.choice(&choice), channel.turn_rad.sin_cos());
            for cutter in cutters {
                // Rims of all channels would be millions of lines: only the tool gets them.
                drawn.add(&cutter.turned_z(turn), &choice, options, steps, false);
            }
        }
        let DrawnCutters { mut lines, caps, instances } = drawn;
        if options.show_links {
            cutters::append_links(cutters, choice.up_to, (0.0, 1.0), &mut lines);
            for channel in &channels {
                cutters::append_links(cutters, channel.up_to, channel.turn_rad.sin_cos(), &mut lines);
            }
        }
        let back = camera.basis().2;
        let depth = |instance: CutterInstance| (Vec3::from_array(instance.tip).dot(back), instance);
        let mut shown: Vec<(f32, CutterInstance)> = instances.into_iter().map(depth).collect();
        shown.sort_by(|a, b| a.0.total_cmp(&b.0));
        let instances: Vec<CutterInstance> = shown.into_iter().map(|s| s.1).collect();
        self.cutters.write(gpu, &instances);
        self.cutter_caps.write(gpu, &caps);
        self.cutter_lines.write(gpu, &lines);
    }

    /// Creates the texture of a picture of `size` pixels that is drawn later.
    pub fn reserve(&mut self, gpu: &Gpu, size: UVec2) {
        self.ensure_target(gpu, clamped(gpu, size), 1);
    }

    fn ensure_target(&mut self, gpu: &Gpu, size: UVec2, samples: u32) {
        if self.target.as_ref().is_some_and(|t| t.size == size && t.samples == samples) {
            return;
        }
        let texture = |label, format, samples, usage| {
            target::create_texture(&gpu.device, label, format, size, samples, usage)
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        // The resolved texture is kept when only the sample count changes, so that the window need not
        // register it again.
        let (colour, view) = match self.target.take() {
            Some(old) if old.size == size => (old.colour, old.view),
            _ => {
                self.generation += 1;
                let usage = attachment | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
                let colour = texture("picture", COLOUR_FORMAT, 1, usage);
                let view = colour.create_view(&Default::default());
                (colour, view)
            }
        };
        let view_of = |t: wgpu::Texture| t.create_view(&Default::default());
        self.target = Some(Target {
            size,
            samples,
            colour,
            view,
            multisampled: (samples > 1)
                .then(|| view_of(texture("picture, samples", COLOUR_FORMAT, samples, attachment))),
            depth: view_of(texture("depth", DEPTH_FORMAT, samples, attachment)),
        });
    }

    /// View of the last picture's texture; `None` before the first picture.
    pub fn view(&self) -> Option<&wgpu::TextureView> {
        self.target.as_ref().map(|t| &t.view)
    }

    /// Number of textures created so far; when it changes, [`Self::view`] is a different texture.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Reads the last picture back.
    ///
    /// # Errors
    /// [`GpuError::Failed`] when nothing was drawn yet or the device fails.
    pub fn read_rgba(&self, gpu: &Gpu) -> Result<Picture, GpuError> {
        let failed = |what: &dyn std::fmt::Display| GpuError::Failed(what.to_string());
        let target = self.target.as_ref().ok_or_else(|| failed(&"no picture was drawn yet"))?;
        let (width, height) = (target.size.x, target.size.y);
        let mut rgba = target::read_back(gpu, &target.colour, target.size, 4)?;
        // Un-premultiply the colour of partly transparent pixels.
        for pixel in rgba.chunks_exact_mut(4).filter(|pixel| !matches!(pixel[3], 0 | 255)) {
            for k in 0..3 {
                pixel[k] = (u32::from(pixel[k]) * 255 / u32::from(pixel[3])).min(255) as u8;
            }
        }
        Ok(Picture { width, height, rgba })
    }
}
