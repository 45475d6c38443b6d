# openapi.yaml as a program reads it: its operations, its schemas, and what of an answer they do not allow.
package Contract;
use strict;
use warnings;
use Exporter 'import';
use FindBin;
use JSON::PP ();
use YAML::XS ();

our @EXPORT = qw(squeezed);

my @methods = qw(get post delete put patch head options);

# Reads the contract; dies on what is no YAML, and on a key that stands twice.
sub new {
    my ($class, $path) = @_;
    local $YAML::XS::Boolean = 'JSON::PP';
    local $YAML::XS::ForbidDuplicateKeys = 1;
    my $self = bless { path => $path // "$FindBin::Bin/../../openapi.yaml" }, $class;

    $self->{doc} = YAML::XS::LoadFile($self->{path});
    return $self;
}

# What a $ref, or a thing that is none, stands for; undef when there is nothing.
sub resolved {
    my ($self, $thing) = @_;
    while (ref $thing eq 'HASH' && defined $thing->{'$ref'}) {
        my ($at, @steps) = ($self->{doc}, split m{/}, $thing->{'$ref'} =~ s{^#/}{}r);
        for my $step (@steps) { $at = ref $at eq 'HASH' ? $at->{$step} : undef }
        $thing = $at;
    }
    return $thing;
}

sub schema { return $_[0]{doc}{components}{schemas}{ $_[1] } // die "there is no schema $_[1]" }

# Every mapping below a thing, with its place: [place, mapping], ... $ref is not followed.
sub mappings {
    my ($self, $thing, $place) = @_;
    ($thing, $place) = ($self->{doc}, '') unless defined $place;
    return map { $self->mappings($thing->[$_], "$place\[$_]") } 0 .. $#$thing if ref $thing eq 'ARRAY';
    return () unless ref $thing eq 'HASH';
    return ([$place, $thing], map { $self->mappings($thing->{$_}, "$place/$_") } sort keys %$thing);
}

# "GET /v1/jobs" => its operation, for all of them.
sub operations {
    my ($self) = @_;
    my %operations;
    for my $path (keys %{ $self->{doc}{paths} }) {
        my $item = $self->{doc}{paths}{$path};
        $operations{ uc($_) . " $path" } = $item->{$_} for grep { $item->{$_} } @methods;
    }
    return %operations;
}

# The parameters of an operation, whole; of one place ("query") or of all.
sub parameters {
    my ($self, $operation, $in) = @_;
    my @all = map { $self->resolved($_) } @{ $operation->{parameters} // [] };
    return grep { !defined $in || $_->{in} eq $in } @all;
}

# The operation that serves a request, and the route that it stands at; HEAD is served by GET.
sub find {
    my ($self, $method, $target) = @_;
    my %operations = $self->operations;
    my ($path) = $target =~ /^([^?]*)/;

    $method = 'GET' if $method eq 'HEAD';
    for my $route (sort { ($a =~ tr/{//) <=> ($b =~ tr/{//) } keys %operations) {
        my $pattern = join '[^/]+', map { quotemeta } split /\{\w+\}/, $route, -1;
        return ($operations{$route}, $route) if "$method $path" =~ /^$pattern$/;
    }
    return ();
}

# What the contract does not say of an answer: { method, target, status, headers, body }, with names of
# headers in small letters.
sub faults_of {
    my ($self, $answer) = @_;
    my ($operation, $route) = $self->find(@$answer{qw(method target)});
    return "$answer->{method} $answer->{target} is in no path" unless $operation;
    my $status = $answer->{status};
    my $response = $self->resolved(
        $operation->{responses}{$status} // $operation->{responses}{ substr($status, 0, 1) . 'XX' });
    return "$route: no status $status" unless $response;
    my %known = map { $_->{name} => 1 } $self->parameters($operation, 'query');
    my @strange = grep { $status < 400 && !$known{$_} } $answer->{target} =~ /[?&]([^=&]+)/g;
    return ((map { "$route: no parameter $_" } @strange),
        map { "$route: $status: $_" } $self->content_faults($response, $answer));
}

sub content_faults {
    my ($self, $response, $answer) = @_;
    my $content = $response->{content} // {};
    my $type = $answer->{headers}{'content-type'};

    return $type && length $answer->{body} ? "has $type, and no content is described" : () unless %$content;
    return 'has no media type, and content is described' unless defined $type;
    ($type) = $type =~ /^([^;\s]*)/;
    my $media = $content->{$type} // return "has the media type $type";
    return () if $answer->{method} eq 'HEAD' || $answer->{status} == 206;
    return map { $self->faults($media->{schema}, $_) } decoded($type, $answer->{body});
}

# The JSON values of a body; of a stream of lines there are many, of other media types none.
sub decoded {
    my ($type, $body) = @_;
    return map { JSON::PP::decode_json($_) } grep { length } split /\n/, $body if $type eq 'application/x-ndjson';
    return $type =~ m{^application/(?:\w+\+)?json$} ? JSON::PP->new->utf8->allow_nonref->decode($body) : ();
}

# Whether a value has a type of JSON, as it was written.
sub is_a {
    my ($type, $value) = @_;
    return ref $value eq 'HASH' if $type eq 'object';
    return ref $value eq 'ARRAY' if $type eq 'array';
    return JSON::PP::is_bool($value) if $type eq 'boolean';
    return 0 if ref $value || !defined $value;
    my $is_text = JSON::PP->new->allow_nonref->encode($value) =~ /^"/;
    return $is_text if $type eq 'string';
    return !$is_text && ($type eq 'number' || $value =~ /^-?\d+$/);
}

# What a schema does not allow of a value. Stricter than a client should be: a member that is not
# described is a fault too. `beside` has the members that stand in other parts of the same allOf.
sub faults {
    my ($self, $schema, $value, $at, $beside) = @_;
    $at //= '';
    $schema = $self->resolved($schema);
    return $schema->{nullable} ? () : "$at is null" unless defined $value;
    if (my $choices = $schema->{oneOf}) {
        my @faults = map { [$self->faults($_, $value, $at)] } @$choices;
        my $fits = grep { !@$_ } @faults;
        return $fits == 1 ? () : ("$at fits $fits of " . @$choices, map { @$_ } @faults);
    }
    my %members = (%{ $beside // {} }, $self->members($schema));
    my @faults = map { $self->faults($_, $value, $at, \%members) } @{ $schema->{allOf} // [] };
    my $type = $schema->{type} // return @faults;
    return (@faults, "$at is no $type") unless is_a($type, $value);
    return (@faults, $self->object_faults($schema, $value, $at, \%members)) if $type eq 'object';
    return (@faults, map { $self->faults($schema->{items}, $value->[$_], "$at\[$_]") } 0 .. $#$value)
        if $type eq 'array';
    return (@faults, value_faults($schema, $value, $at));
}

# The names of the members that a schema has, those of its allOf included.
sub members {
    my ($self, $schema) = @_;
    $schema = $self->resolved($schema);
    return ((map { $_ => 1 } keys %{ $schema->{properties} // {} }),
        map { $self->members($_) } @{ $schema->{allOf} // [] });
}

sub object_faults {
    my ($self, $schema, $value, $at, $members) = @_;
    my $properties = $schema->{properties} // {};
    my @faults = map { "$at/$_ is missing" } grep { !exists $value->{$_} } @{ $schema->{required} // [] };
    for my $name (sort keys %$value) {
        my $of = $properties->{$name} // $schema->{additionalProperties};
        push @faults, $self->faults($of, $value->{$name}, "$at/$name") if ref $of;
        push @faults, "$at/$name is not described" unless ref $of || $members->{$name};
    }
    return @faults;
}

sub value_faults {
    my ($schema, $value, $at) = @_;
    my $words = $schema->{enum};
    return "$at is $value, not one of its words" if $words && !grep { defined && $_ eq $value } @$words;
    return "$at is $value, below its minimum" if defined $schema->{minimum} && $value < $schema->{minimum};
    return "$at is $value, above its maximum" if defined $schema->{maximum} && $value > $schema->{maximum};
    return ();
}

# A text with one blank where there were some, so that lines may break anywhere.
sub squeezed { return join ' ', split ' ', $_[0] // '' }

1;
