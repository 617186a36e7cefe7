//! The description of the HTTP interface (OpenAPI), from the routes and from the types of their bodies.
//!
//! Only tests make it: they compare it with `openapi.json`, which the panel serves.

use utoipa::openapi::path::{Operation, Parameter, ParameterBuilder, ParameterIn};
use utoipa::openapi::schema::{ObjectBuilder, OneOfBuilder, Schema, SchemaType, Type};
use utoipa::openapi::{self, RefOr, Required};
use utoipa::{IntoResponses, OpenApi, PartialSchema, ToSchema};

use super::line::{self, faults};
use super::modules::{self, values};
use super::objects::{self, ObjectValue};
use super::problem::Problem;
use super::routes::{self, SHORT, STATIONS};
use super::station::AmountState;
use super::station::handlers as stations;
use super::station::spec::{self, NewStation};
use super::stream::{self, Lost, NewsEvent, TelegramEvent};
use super::{acyclic, history, inputs, master, parameters, switches};
use crate::host::list::{DEVICES, Device, Group};

/// The description of the API.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "profidrive",
        description = "See emulated PROFIBUS stations and CANopen nodes and control what acts on them. A station is named by \
            its line and its address, or by its address alone where one line has it. A request that is refused changes \
            nothing.",
    ),
    paths(
        routes::description,
        line::state::list,
        line::state::state,
        faults::list,
        faults::add,
        faults::replace,
        faults::clear,
        faults::remove,
        history::capture,
        stations::list,
        spec::add,
        stations::state,
        stations::remove,
        stations::why,
        inputs::read,
        inputs::change,
        inputs::nominal,
        inputs::provoke,
        inputs::press,
        inputs::power,
        switches::read,
        switches::set,
        parameters::list,
        parameters::read,
        parameters::write,
        objects::list,
        objects::read,
        objects::write,
        modules::texts,
        modules::diagnosis,
        modules::raise,
        modules::end_diagnosis,
        values::read_input,
        values::force,
        values::release,
        values::follow,
        values::stop_following,
        values::read_output,
        acyclic::records,
        acyclic::record,
        acyclic::change_record,
        acyclic::alarms,
        acyclic::raise_alarm,
        acyclic::forget_alarms,
        acyclic::send_status,
        acyclic::channels,
        master::read,
        master::order,
        master::leave,
        history::samples,
        history::samples_csv,
        stream::events,
        history::events,
    ),
    components(schemas(Problem, NewsEvent, TelegramEvent, Lost))
)]
struct Api;

/// With the variables of the paths, and the paths by the address alone.
fn described() -> openapi::OpenApi {
    let mut api = Api::openapi();
    for (path, item) in &mut api.paths.paths {
        let names = path.split('{').skip(1).filter_map(|rest| rest.split('}').next());
        let variables: Vec<_> = names.map(variable).collect();
        for operation in operations(item) {
            operation.parameters.get_or_insert_default().splice(..0, variables.clone());
        }
    }
    let of_stations = api.paths.paths.iter().filter_map(|(path, item)| {
        let rest = path.strip_prefix(STATIONS)?;
        Some((format!("{SHORT}{rest}"), by_address(item.clone())))
    });
    let short: Vec<_> = of_stations.collect();
    api.paths.paths.extend(short);
    api
}

/// A variable of a path.
fn variable(name: &str) -> Parameter {
    let number = |highest: Option<usize>| {
        ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(0)).maximum(highest)
    };
    let text = |pattern: Option<&str>| ObjectBuilder::new().schema_type(Type::String).pattern(pattern);
    let (schema, about) = match name {
        "address" => (number(Some(127)), None),
        "number" => (number(None), None),
        "slot" => {
            (text(None), Some("The number of the slot, or the name of its module if only one slot has it"))
        }
        "slot_number" => (number(Some(254)), Some("0: the station; from 1: its modules")),
        "record" => (number(Some(255)), Some("The index of the record")),
        "octet" => (number(Some(243)), Some("The first octet of the value in the slot, from 0")),
        "type" => (
            text(None),
            Some(
                "bit0 to bit7, unsigned8, unsigned16, unsigned32, signed8, signed16, signed32, float32; big-endian",
            ),
        ),
        "index" => (text(Some("^(0x)?[0-9A-Fa-f]{1,4}h?$")), Some("hexadecimal, as 6041")),
        "sub" => (text(Some("^(0x)?[0-9A-Fa-f]{1,2}h?$")), Some("hexadecimal, as 0")),
        "key" => (
            text(Some("^[0-9]{1,4}([.][0-9]{1,3})?$")),
            Some("its number, as 1004; of an array with the element, as 945.0"),
        ),
        _line => (text(None), None),
    };
    let variable = ParameterBuilder::new().name(name).parameter_in(ParameterIn::Path);
    variable.required(Required::True).description(about).schema(Some(schema)).build()
}

fn operations(item: &mut openapi::PathItem) -> impl Iterator<Item = &mut Operation> {
    [&mut item.get, &mut item.put, &mut item.post, &mut item.patch, &mut item.delete].into_iter().flatten()
}

/// The operations of a path without the line.
fn by_address(mut item: openapi::PathItem) -> openapi::PathItem {
    for operation in operations(&mut item) {
        if let Some(parameters) = &mut operation.parameters {
            parameters.retain(|parameter| parameter.name != "line");
        }
        operation.operation_id = operation.operation_id.take().map(|name| format!("{name}_by_address"));
    }
    item
}

/// What every operation may answer instead of what it is for.
#[derive(IntoResponses)]
#[expect(dead_code, reason = "only described")]
pub(super) enum Problems {
    #[response(
        status = 400,
        description = "The request is not understood",
        content_type = "application/problem+json"
    )]
    BadRequest(Problem),
    #[response(
        status = 403,
        description = "A request of another web site, or another name in Host",
        content_type = "application/problem+json"
    )]
    Forbidden(Problem),
    #[response(status = 404, description = "It does not exist", content_type = "application/problem+json")]
    NotFound(Problem),
    #[response(
        status = 408,
        description = "The request took too long",
        content_type = "application/problem+json"
    )]
    Timeout(Problem),
    #[response(
        status = 409,
        description = "Not possible in the present state",
        content_type = "application/problem+json"
    )]
    Conflict(Problem),
    #[response(
        status = 413,
        description = "The body is too large",
        content_type = "application/problem+json"
    )]
    TooLarge(Problem),
    #[response(
        status = 415,
        description = "The body is not application/json",
        content_type = "application/problem+json"
    )]
    MediaType(Problem),
    #[response(status = 422, description = "A value is wrong", content_type = "application/problem+json")]
    Value(Problem),
    #[response(
        status = 503,
        description = "The bus has ended, or does not answer in time",
        content_type = "application/problem+json"
    )]
    Unavailable(Problem),
}

impl PartialSchema for ObjectValue {
    /// A number, whole or not, or a text. Derived, a whole number would match two of three.
    fn schema() -> RefOr<Schema> {
        let one = |kind| ObjectBuilder::new().schema_type(kind);
        OneOfBuilder::new().item(one(Type::Number)).item(one(Type::String)).into()
    }
}

impl ToSchema for ObjectValue {}

impl PartialSchema for AmountState {
    fn schema() -> RefOr<Schema> {
        let kinds = [Type::Number, Type::Boolean, Type::String, Type::Null];
        ObjectBuilder::new().schema_type(SchemaType::from_iter(kinds)).into()
    }
}

impl ToSchema for AmountState {}

impl ToSchema for NewStation {}

impl PartialSchema for NewStation {
    fn schema() -> RefOr<Schema> {
        let text = || ObjectBuilder::new().schema_type(Type::String);
        let address = ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(0)).maximum(Some(127));
        let named = ObjectBuilder::new()
            .property("line", text())
            .property("address", address)
            .required("address")
            .property("device", text().enum_values(Some(DEVICES.iter().map(Device::name))))
            .required("device");
        let grouped = Group::ALL.into_iter().fold(OneOfBuilder::new().item(named), |all, group| {
            let one = ObjectBuilder::new().schema_type(SchemaType::Type(Type::Object));
            let one = one.property("line", text()).property(group.name(), group.open_api());
            all.item(one.required(group.name()))
        });
        grouped.into()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;

    use super::*;

    const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/panel/openapi.json");

    /// The methods and paths of the router, by its text: the router does not tell them.
    fn routed(text: &str) -> BTreeSet<String> {
        let begin = text.find("Router::new()").unwrap();
        let end = begin + text[begin..].find(".fallback(").unwrap();
        let mut routes = BTreeSet::new();
        let calls = text[begin..end].split(".route(").skip(1).flat_map(|part| {
            let mut pieces = part.split(".station(");
            let first = pieces.next().map(|route| (vec![""], route));
            first.into_iter().chain(pieces.map(|route| (vec![STATIONS, SHORT], route)))
        });
        for (before, route) in calls {
            let path = route.split('"').nth(1).unwrap();
            for method in ["get", "post", "put", "patch", "delete"] {
                let handled = [" ", ".", "("].iter().any(|before| {
                    let call = format!("{before}{method}(");
                    route.split('"').nth(2).unwrap().contains(&call)
                });
                for before in
                    before.iter().filter(|before| handled && format!("{before}{path}").starts_with("/api/"))
                {
                    routes.insert(format!("{method} {before}{path}"));
                }
            }
        }
        routes
    }

    #[test]
    fn the_description_that_is_served_is_that_of_the_routes() {
        let mut description = serde_json::to_string_pretty(&described()).unwrap();
        description.push('\n');
        if std::env::var_os("PROFIDRIVE_REWRITE").is_some() {
            fs::write(FILE, &description).unwrap();
        }
        let served = fs::read_to_string(FILE).unwrap_or_default();
        assert_eq!(served, description, "rewrite it with PROFIDRIVE_REWRITE=1");
    }

    #[test]
    fn every_route_is_described_with_every_method() {
        let routes = routed(include_str!("routes.rs"));
        assert!(routes.len() >= 60, "{routes:?}");
        let description = serde_json::to_value(described()).unwrap();
        let mut all = BTreeSet::new();
        for (path, methods) in description["paths"].as_object().unwrap() {
            all.extend(methods.as_object().unwrap().keys().map(|method| format!("{method} {path}")));
        }
        assert_eq!(routes, all);
    }
}
