//! Declaration of the structs that shaders read.

/// Declares a struct in shader layout. In tests, it implements [`ShaderStruct`] too, so that a test can compare the
/// fields with those of the struct in WGSL.
macro_rules! shader_struct {
    ($(#[$attribute:meta])* $visibility:vis struct $name:ident {
        $($(#[$note:meta])* $of_field:vis $field:ident: $ty:ty,)+
    }) => {
        $(#[$attribute])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
        $visibility struct $name { $($(#[$note])* $of_field $field: $ty,)+ }

        #[cfg(test)]
        impl crate::shared::shader_struct::ShaderStruct for $name {
            const FIELDS: &[(&str, usize, usize)] =
                &[$((stringify!($field), std::mem::offset_of!(Self, $field), size_of::<$ty>()),)+];
        }
    };
}

pub(crate) use shader_struct;

/// Struct in shader layout whose fields a test can list.
#[cfg(test)]
pub(crate) trait ShaderStruct {
    /// Name, offset and size of each field.
    const FIELDS: &[(&str, usize, usize)];
}
