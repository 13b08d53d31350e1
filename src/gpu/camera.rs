//! Orbit camera. World coordinates in mm with Z as the axis of rotation, angles in radians, pixels from the
//! top left corner of the picture.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Mat4, Vec2, Vec3, Vec4};

use super::view::{View, ViewTarget, ViewTargets};

/// Projection of the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// Near objects appear larger.
    #[default]
    Perspective,
    /// Parallel rays; lengths can be compared across the picture.
    Orthographic,
}

/// A camera that circles a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Point in the middle of the picture, mm.
    pub target: Vec3,
    /// Angle of the eye about Z, rad.
    pub yaw_rad: f32,
    /// Elevation of the eye above the target, −π/2 … π/2 rad.
    pub pitch_rad: f32,
    /// Distance of the eye from the target, mm.
    pub distance: f32,
    /// Vertical angle of view, rad.
    pub fov_rad: f32,
    /// Projection.
    pub projection: Projection,
    /// +1: Z points up in the picture; −1: down.
    pub up_sign: f32,
    /// Bounding sphere (centre, radius; mm) of everything drawn; it bounds the depth range.
    pub bounds: (Vec3, f32),
}

/// A ray from the eye into the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewRay {
    /// Origin, mm.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
}

impl Camera {
    /// A camera for a standard view in a picture of `aspect` = width / height. A section number beyond the
    /// plan gives the view of the channel.
    pub fn standard(view: View, framing: &ViewTargets, aspect: f32) -> Self {
        let mut camera = Self {
            target: framing.wheel.center,
            yaw_rad: 0.0,
            pitch_rad: 0.0,
            distance: 1.0,
            fov_rad: 28f32.to_radians(),
            projection: Projection::Perspective,
            up_sign: framing.up_sign,
            bounds: (framing.wheel.center, framing.wheel.radius),
        };
        let iso = framing.wheel.from;
        let frame = match view {
            View::Iso => framing.wheel,
            View::Front => ViewTarget { from: Vec3::new(iso.x, iso.y, 0.0), ..framing.wheel },
            View::Top => ViewTarget { from: Vec3::new(0.0, 0.0, framing.up_sign), ..framing.wheel },
            View::Channel => framing.channel,
            View::Section(k) => *framing.sections.get(k.wrapping_sub(1)).unwrap_or(&framing.channel),
        };
        camera.look_from(frame.from);
        if view == View::Top {
            camera.yaw_rad = iso.y.atan2(iso.x);
        }
        camera.fit(frame.center, frame.radius, aspect);
        match view {
            View::Iso | View::Front | View::Top => camera.fit_points(&framing.wheel_outline, aspect),
            View::Channel => camera.fit_points(&framing.channel_outline, aspect),
            View::Section(_) => {}
        }
        camera
    }

    /// Rotates the camera so that it looks at its target from `direction`.
    pub fn look_from(&mut self, direction: Vec3) {
        let d = direction.normalize_or(Vec3::X);
        self.pitch_rad = (d.z * self.up_sign).clamp(-1.0, 1.0).asin();
        if d.x.hypot(d.y) > 1e-6 {
            self.yaw_rad = d.y.atan2(d.x);
        }
    }

    /// Targets a sphere and sets the distance so that it fills the picture.
    pub fn fit(&mut self, center: Vec3, radius: f32, aspect: f32) {
        let half_vertical = self.fov_rad / 2.0;
        let half_horizontal = (half_vertical.tan() * aspect).atan();
        let half = half_vertical.min(half_horizontal);
        self.target = center;
        self.distance = match self.projection {
            Projection::Perspective => radius / half.sin(),
            Projection::Orthographic => radius / (half_vertical.tan() * aspect.min(1.0)),
        };
    }

    /// Shifts the camera, keeping its direction, so that `points` just fill the picture.
    pub fn fit_points(&mut self, points: &[Vec3], aspect: f32) {
        /// Share of the picture to fill.
        const FILL: f32 = 0.92;
        // Fixed-point iteration, because the scale depends on each point's depth; it converges fast.
        for _ in 0..12 {
            let (right, up, back) = self.basis();
            let tan = (self.fov_rad / 2.0).tan();
            let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
            for &point in points {
                let d = point - self.target;
                let depth = match self.projection {
                    Projection::Perspective => (self.distance - d.dot(back)).max(self.distance * 0.05),
                    Projection::Orthographic => self.distance,
                };
                let seen = Vec2::new(d.dot(right) / aspect, d.dot(up)) / (depth * tan);
                low = low.min(seen);
                high = high.max(seen);
            }
            if !(low.is_finite() && high.is_finite()) {
                return;
            }
            let middle = (low + high) / 2.0 * self.distance * tan;
            self.target += right * middle.x * aspect + up * middle.y;
            let scale = (high - low).max_element() / 2.0 / FILL;
            self.distance *= scale.clamp(0.25, 4.0);
        }
    }

    /// Unit vectors right, up and back (towards the viewer), in the world frame.
    pub fn basis(&self) -> (Vec3, Vec3, Vec3) {
        let (sin_yaw, cos_yaw) = self.yaw_rad.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch_rad.sin_cos();
        let back = Vec3::new(cos_pitch * cos_yaw, cos_pitch * sin_yaw, self.up_sign * sin_pitch);
        let right = Vec3::new(-sin_yaw, cos_yaw, 0.0) * self.up_sign;
        (right, back.cross(right), back)
    }

    /// Position of the eye, mm.
    pub fn eye(&self) -> Vec3 {
        self.target + self.basis().2 * self.distance
    }

    /// World → clip space (z 0…1, y up).
    pub fn clip_from_world(&self, aspect: f32) -> Mat4 {
        let (_, up, back) = self.basis();
        let eye = self.eye();
        let view = glam::camera::rh::view::look_to_mat4(eye, -back, up);
        // Near and far planes enclose the scene tightly, so that depth resolution stays high at any distance.
        let ahead = (eye - self.bounds.0).dot(back);
        let far = (ahead + self.bounds.1).max(self.bounds.1 * 0.02);
        let near = (ahead - self.bounds.1).max(far * 2e-3);
        let projection = match self.projection {
            Projection::Perspective => {
                glam::camera::rh::proj::directx::perspective(self.fov_rad, aspect, near, far)
            }
            Projection::Orthographic => {
                let h = self.distance * (self.fov_rad / 2.0).tan();
                let w = h * aspect;
                // A near plane behind the eye, or zooming in would clip the wheel.
                let near = ahead - self.bounds.1;
                glam::camera::rh::proj::directx::orthographic(-w, w, -h, h, near, far)
            }
        };
        projection * view
    }

    /// Ray through a pixel of a picture of `size`.
    pub fn ray(&self, pixel: Vec2, size: Vec2) -> ViewRay {
        let (right, up, back) = self.basis();
        let h = (self.fov_rad / 2.0).tan();
        let x = (2.0 * pixel.x / size.x - 1.0) * h * size.x / size.y;
        let y = (1.0 - 2.0 * pixel.y / size.y) * h;
        match self.projection {
            Projection::Perspective => {
                ViewRay { origin: self.eye(), direction: (right * x + up * y - back).normalize() }
            }
            Projection::Orthographic => {
                // Start in front of the whole scene, as the eye may be inside the part.
                let out = self.distance.max((self.bounds.0 - self.target).length() + self.bounds.1 * 1.5);
                let on_plane = self.target + (right * x + up * y) * self.distance;
                ViewRay { origin: on_plane + back * out, direction: -back }
            }
        }
    }

    /// Pixel at which a world point appears, if it is in front of the camera.
    pub fn project(&self, point: Vec3, size: Vec2) -> Option<Vec2> {
        let clip: Vec4 = self.clip_from_world(size.x / size.y) * point.extend(1.0);
        (clip.w > 0.0).then(|| {
            Vec2::new((clip.x / clip.w + 1.0) * 0.5 * size.x, (1.0 - clip.y / clip.w) * 0.5 * size.y)
        })
    }

    /// Rotates the scene about `pivot`, which stays at its pixel; a drag to the right (`pixels.x` > 0)
    /// rotates it to the right.
    pub fn orbit(&mut self, pixels: Vec2, pivot: Vec3) {
        const RADIANS_PER_PIXEL: f32 = 0.008;
        let before = self.basis();
        let offset = self.target - pivot;
        let held = (offset.dot(before.0), offset.dot(before.1), offset.dot(before.2));
        self.yaw_rad -= pixels.x * RADIANS_PER_PIXEL * self.up_sign;
        self.pitch_rad = (self.pitch_rad + pixels.y * RADIANS_PER_PIXEL).clamp(-FRAC_PI_2, FRAC_PI_2);
        let after = self.basis();
        self.target = pivot + after.0 * held.0 + after.1 * held.1 + after.2 * held.2;
    }

    /// Pans so that the point `grabbed` moves by `pixels` in a picture of `size`.
    pub fn pan(&mut self, pixels: Vec2, grabbed: Vec3, size: Vec2) {
        let (right, up, back) = self.basis();
        let depth = match self.projection {
            Projection::Perspective => (self.eye() - grabbed).dot(back).max(self.distance * 1e-2),
            Projection::Orthographic => self.distance,
        };
        let mm_per_pixel = 2.0 * depth * (self.fov_rad / 2.0).tan() / size.y;
        self.target += (up * pixels.y - right * pixels.x) * mm_per_pixel;
    }

    /// Zooms by `factor` (< 1: nearer) about `point`, which stays at its pixel.
    pub fn zoom(&mut self, factor: f32, point: Vec3) {
        let reach = self.bounds.1.max(1e-3);
        let distance = (self.distance * factor).clamp(reach * 5e-3, reach * 50.0);
        let factor = distance / self.distance;
        self.distance = distance;
        self.target = point + (self.target - point) * factor;
    }

    /// Interpolates to the camera `to` by `share` (0…1); projection and bounds are those of `to`.
    pub fn interpolate_to(&self, to: &Self, share: f32) -> Self {
        if share >= 1.0 {
            return *to;
        }
        let between = |a: f32, b: f32| a + (b - a) * share;
        let turn = (to.yaw_rad - self.yaw_rad + PI).rem_euclid(TAU) - PI;
        Self {
            target: self.target.lerp(to.target, share),
            yaw_rad: self.yaw_rad + turn * share,
            pitch_rad: between(self.pitch_rad, to.pitch_rad),
            // Geometric interpolation, so that the zoom appears uniform.
            distance: self.distance * (to.distance / self.distance.max(1e-6)).powf(share),
            fov_rad: between(self.fov_rad, to.fov_rad),
            ..*to
        }
    }

    /// Moves `point` to the middle of the picture.
    pub fn center_on(&mut self, point: Vec3) {
        self.target = point;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Vec2 = Vec2::new(900.0, 700.0);

    fn framing(up_sign: f32) -> ViewTargets {
        let wheel = ViewTarget {
            center: Vec3::new(3.0, -2.0, 10.0),
            radius: 120.0,
            from: Vec3::new(0.4, -0.7, 0.6 * up_sign).normalize(),
        };
        let ring = |r: f32, z: f32| {
            (0..24).map(move |i| {
                let (sin, cos) = (i as f32 / 24.0 * TAU).sin_cos();
                Vec3::new(3.0 + r * cos, r * sin - 2.0, z)
            })
        };
        ViewTargets {
            wheel,
            channel: ViewTarget { radius: 40.0, ..wheel },
            sections: vec![],
            wheel_outline: ring(110.0, -20.0).chain(ring(40.0, 50.0)).collect(),
            channel_outline: ring(30.0, 10.0).collect(),
            up_sign,
        }
    }

    fn cameras() -> Vec<Camera> {
        let mut all = Vec::new();
        for up_sign in [1.0, -1.0] {
            for view in [View::Iso, View::Front, View::Top, View::Channel, View::Section(1)] {
                for projection in [Projection::Perspective, Projection::Orthographic] {
                    let mut camera = Camera::standard(view, &framing(up_sign), SIZE.x / SIZE.y);
                    camera.projection = projection;
                    all.push(camera);
                }
            }
        }
        all
    }

    #[test]
    fn basis_is_right_handed_and_up_is_up() {
        for camera in cameras() {
            let (right, up, back) = camera.basis();
            assert!((right.cross(up) - back).length() < 1e-5, "{camera:?}");
            assert!(up.z * camera.up_sign >= -1e-6, "{camera:?}");
        }
    }

    #[test]
    fn a_point_projects_to_the_pixel_its_ray_starts_from() {
        for camera in cameras() {
            for pixel in [Vec2::new(450.0, 350.0), Vec2::new(120.0, 60.0), Vec2::new(800.0, 600.0)] {
                let ray = camera.ray(pixel, SIZE);
                let back = camera.project(ray.origin + ray.direction * 300.0, SIZE).expect("in front");
                assert!((back - pixel).length() < 0.05, "{pixel} came back as {back}, {camera:?}");
            }
        }
    }

    #[test]
    fn a_fitted_sphere_stays_in_the_picture_and_touches_its_border() {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            for size in [SIZE, Vec2::new(400.0, 900.0)] {
                let mut camera = Camera::standard(View::Iso, &framing(1.0), 1.0);
                camera.projection = projection;
                camera.fit(camera.target, 120.0, size.x / size.y);
                let (right, up, _) = camera.basis();
                let mut widest = 0f32;
                for i in 0..64 {
                    let (s, c) = (i as f32 / 64.0 * TAU).sin_cos();
                    let p = camera.target + (right * c + up * s) * 120.0;
                    let q = (camera.project(p, size).expect("in front") / size - 0.5).abs();
                    widest = widest.max(q.x.max(q.y));
                }
                assert!((0.45..=0.501).contains(&widest), "{widest} of the half picture");
            }
        }
    }

    #[test]
    fn fitted_points_fill_the_picture_evenly() {
        let framing = framing(1.0);
        for projection in [Projection::Perspective, Projection::Orthographic] {
            for size in [SIZE, Vec2::new(400.0, 900.0)] {
                let mut camera = Camera::standard(View::Iso, &framing, size.x / size.y);
                camera.projection = projection;
                camera.fit_points(&framing.wheel_outline, size.x / size.y);
                let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
                for &point in &framing.wheel_outline {
                    let seen = camera.project(point, size).expect("in front") / size;
                    (low, high) = (low.min(seen), high.max(seen));
                }
                assert!((low + high - 1.0).abs().max_element() < 0.02, "off the middle: {low} {high}");
                let filled = (high - low).max_element();
                assert!((filled - 0.92).abs() < 0.02, "{filled} of the picture");
            }
        }
    }

    #[test]
    fn orbit_zoom_and_pan_keep_the_point_under_the_cursor() {
        for start in cameras() {
            let pixel = Vec2::new(600.0, 200.0);
            let ray = start.ray(pixel, SIZE);
            let point = ray.origin + ray.direction * 350.0;
            let mut camera = start;
            camera.orbit(Vec2::new(37.0, 11.0), point);
            let held = camera.project(point, SIZE).expect("in front");
            assert!((held - pixel).length() < 0.1, "orbit moved it to {held}");
            camera.zoom(0.8, point);
            let held = camera.project(point, SIZE).expect("in front");
            assert!((held - pixel).length() < 0.1, "zoom moved it to {held}");
            camera.pan(Vec2::new(-20.0, 30.0), point, SIZE);
            let held = camera.project(point, SIZE).expect("in front");
            assert!((held - pixel - Vec2::new(-20.0, 30.0)).length() < 0.1, "pan moved it to {held}");
        }
    }

    #[test]
    fn all_of_the_scene_lies_in_the_depth_range() {
        for camera in cameras() {
            let clip_from_world = camera.clip_from_world(1.3);
            let (center, radius) = camera.bounds;
            for d in [camera.basis().2, -camera.basis().2] {
                let p = clip_from_world * (center + d * radius * 0.999).extend(1.0);
                if p.w > 0.0 {
                    let z = p.z / p.w;
                    let inside_eye = (camera.eye() - camera.bounds.0).length() < radius;
                    assert!((-1e-4..=1.0001).contains(&z) || inside_eye, "{z} {camera:?}");
                }
            }
        }
    }
}
