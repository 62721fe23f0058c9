//! Device without a window.

use crate::StageError;
use pelage_runtime::wgpu;

/// Device, queue, and adapter information. Clones refer to the same device.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// Device handle.
    pub device: wgpu::Device,
    /// Queue of the device.
    pub queue: wgpu::Queue,
    /// Name, driver and kind of the adapter.
    pub info: wgpu::AdapterInfo,
}

impl Gpu {
    /// Opens wgpu's preferred adapter with all supported features that drawing and timing can use. The environment
    /// variables `WGPU_ADAPTER_NAME` and `WGPU_BACKEND` select another adapter.
    ///
    /// Fails with [`StageError::NoAdapter`] with a list of what was tried.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn open() -> Result<Self, StageError> {
        Self::with(Self::wanted_features(), None)
    }

    /// Returns all adapter features that drawing and measuring can use.
    #[cfg(not(target_arch = "wasm32"))]
    fn wanted_features() -> wgpu::Features {
        wgpu::Features::TEXTURE_COMPRESSION_BC
            | wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS
            | wgpu::Features::PIPELINE_STATISTICS_QUERY
    }

    /// Opens the given adapter, for example one that can draw to a window. Enables all supported features that drawing
    /// and timing can use.
    ///
    /// Fails with [`StageError::NoAdapter`] if the adapter returns no device.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn of_adapter(adapter: &wgpu::Adapter) -> Result<Self, StageError> {
        pollster::block_on(Self::device(adapter, Self::wanted_features(), None))
    }

    /// Requests a device with the supported subset of `wanted`. With `limits: None` it has the adapter's own limits.
    async fn device(
        adapter: &wgpu::Adapter,
        wanted: wgpu::Features,
        limits: Option<wgpu::Limits>,
    ) -> Result<Self, StageError> {
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("pelage"),
                required_features: wanted & adapter.features(),
                required_limits: limits.unwrap_or_else(|| adapter.limits()),
                ..Default::default()
            })
            .await
            .map_err(|error| StageError::NoAdapter(error.to_string()))?;
        Ok(Self { device, queue, info: adapter.get_info() })
    }

    /// Opens the same adapter with the supported subset of `wanted`. With `limits: None` the device has the adapter's
    /// own limits. An application that must run everywhere passes [`wgpu::Limits::default`].
    ///
    /// Fails with [`StageError::NoAdapter`] with a list of what was tried.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn with(wanted: wgpu::Features, limits: Option<wgpu::Limits>) -> Result<Self, StageError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        pollster::block_on(Self::request(&instance, None, wanted, limits))
    }

    /// Returns a description of the adapter that [`Self::open`] would use, and of its driver. Pictures depend on both.
    /// Creates no device.
    ///
    /// Fails with the errors of [`Self::open`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn describe_adapter() -> Result<String, StageError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = pollster::block_on(wgpu::util::initialize_adapter_from_env_or_default(&instance, None));
        adapter.map(|adapter| describe(&adapter.get_info())).map_err(|error| StageError::NoAdapter(error.to_string()))
    }

    /// Returns a description of this adapter, in the format of [`Self::describe_adapter`].
    pub fn description(&self) -> String {
        describe(&self.info)
    }

    /// Opens an adapter that can draw on `surface`, without blocking; otherwise like [`Self::with`]. A browser requires
    /// this, because a request completes only between two turns of its event loop.
    ///
    /// Fails with the errors of [`Self::with`].
    pub async fn request(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
        wanted: wgpu::Features,
        limits: Option<wgpu::Limits>,
    ) -> Result<Self, StageError> {
        let adapter = wgpu::util::initialize_adapter_from_env_or_default(instance, surface)
            .await
            .map_err(|error| StageError::NoAdapter(error.to_string()))?;
        Self::device(&adapter, wanted, limits).await
    }

    /// Blocks until all submitted work is done. In a browser, where blocking is impossible, it returns immediately.
    pub fn wait(&self) -> Result<(), StageError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map(drop).map_err(device_error)
    }

    /// Maps a buffer with usage `MAP_READ`, which the device must have finished writing. Returns a copy of its
    /// contents.
    pub fn read_buffer(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, StageError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result)));
        self.wait()?;
        receiver.recv().map_err(device_error)?.map_err(device_error)?;
        let bytes = buffer.slice(..).get_mapped_range().map_err(device_error)?.to_vec();
        buffer.unmap();
        Ok(bytes)
    }

    /// Returns a copy of the contents of a buffer with usage `COPY_SRC`.
    pub fn copy_of(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, StageError> {
        let copy = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("buffer readback"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        self.read_buffer(&copy)
    }

    /// Returns the texels of one array layer of an uncompressed texture with `COPY_SRC`, row-major, without padding.
    pub fn read_texture(&self, texture: &wgpu::Texture, layer: u32) -> Result<Vec<u8>, StageError> {
        let (width, height) = (texture.width(), texture.height());
        let texel_bytes =
            texture.format().block_copy_size(None).ok_or_else(|| device_error("a texture without a texel size"))?;
        let row_bytes = width * texel_bytes;
        let padded = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("texture readback"),
            size: u64::from(padded) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x: 0, y: 0, z: layer }, ..texture.as_image_copy() },
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        self.queue.submit([encoder.finish()]);
        let bytes = self.read_buffer(&buffer)?;
        let mut texels = Vec::with_capacity(row_bytes as usize * height as usize);
        bytes.chunks_exact(padded as usize).for_each(|row| texels.extend_from_slice(&row[..row_bytes as usize]));
        Ok(texels)
    }
}

fn describe(info: &wgpu::AdapterInfo) -> String {
    format!("{:?} {} {} {}", info.backend, info.name, info.driver, info.driver_info)
}

/// Returns the error of a device that stopped responding.
pub(crate) fn device_error(error: impl std::fmt::Display) -> StageError {
    StageError::Device(error.to_string())
}
