#!/usr/bin/perl
# openapi.yaml says what the route table says: paths, methods, statuses; the parameters of each
# process are those of its description, with types, ranges, words and defaults; and a record, the
# data of a progress event and a report have the members that are described, with their types.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $yaml = Vt::slurp("$FindBin::Bin/../../openapi.yaml");

# The part of YAML that the file keeps to: block mappings by indentation, no tabs.
my (%operations, %uses, $section, $path, $operation, $in_responses);
for my $line (split /\n/, $yaml) {
    if ($line =~ /^(\w+):/) { $section = $1 }
    elsif ($section eq 'paths' && $line =~ m{^  (/\S*):$}) { $path = $1 }
    elsif ($section eq 'paths' && $line =~ /^    (get|post|delete|put|patch|head|options):$/) {
        $operation = uc "$1" . " $path";
        $operation = uc($1) . " $path";
        $operations{$operation} = {};
        $in_responses = 0;
    } elsif ($section eq 'paths' && $line =~ /^      (\w+):/) { $in_responses = $1 eq 'responses' }
    elsif ($section eq 'paths' && $in_responses && $line =~ /^        "(\d+)":(?: \{\$ref: \S+\})?$/) {
        $operations{$operation}{$1} = 1;
    } elsif ($section eq 'paths' && $line =~ m{^        - \{\$ref: "#/components/parameters/(\w+)"\}$}) {
        push @{ $uses{$operation} }, $1;
    }
}
like $yaml, qr/\Aopenapi: 3\.0\.3$/m, 'it is OpenAPI 3.0.3';
unlike $yaml, qr/\t/, 'it has no tabs';
my %references = map { $_ => 1 } $yaml =~ m{\$ref: "#/components/(\w+/\w+)"}g;
for my $reference (sort keys %references) {
    my ($kind, $name) = split m{/}, $reference;
    like $yaml, qr/^  $kind:\n(?:(?:    .*)?\n)*?    $name:/m, "$reference is defined";
}

my (undef, undef, $printed) = Vt::run('--print-routes');
my %routes;
for my $line (split /\n/, $printed) {
    my ($method, $route, @codes) = split / /, $line;
    $routes{"$method $route"} = { map { $_ => 1 } @codes };
}
cmp_ok scalar(keys %routes), '>', 10, 'there is a route table';
is_deeply [sort keys %operations], [sort keys %routes], 'every route is documented, and no other';
for my $route (sort keys %routes) {
    is_deeply [sort keys %{ $operations{$route} // {} }], [sort keys %{ $routes{$route} }],
        "$route: the same statuses";
}

my $daemon = Vt->start;
my @processes = map { $_->{id} } @{ json($daemon->get('/v1/processes'))->{processes} };
is_deeply [sort map { m{^POST /v1/(\w+)$} ? $1 : () } keys %operations], [sort @processes],
    'every process that is offered has a path of its own';
my (%taken, %given);
for my $process (@processes) {
    my $described = json($daemon->get("/v1/processes/$process"));
    my %schemas = map { $_ => $described->{inputs}{$_}{schema} }
        grep { !is_cloud($described->{inputs}{$_}{schema}) } keys %{ $described->{inputs} };
    my @uses = grep { !/^(?:prefer|jobName|inputOf|idempotencyKey)$/ } @{ $uses{"POST /v1/$process"} // [] };
    my %component = map { name_of($_) => $_ } @uses;
    is_deeply [sort map { name_of($_) } @uses], [sort keys %schemas],
        "$process: its parameters are documented, each once, and no other";
    is_deeply plain(schema_of(block('parameters', $component{$_}))), plain($schemas{$_}),
        "$process, $_: types, ranges, words and default" for grep { $component{$_} } sort keys %schemas;
    $taken{$_} = 1 for keys %schemas;
    $given{$_} = 1 for keys %{ $described->{outputs} };
}
is_deeply [sort map { name_of($_) } @{ $uses{'POST /v1/processes/{processID}/execution'} }],
    [sort qw(Prefer processID name input Idempotency-Key), keys %taken], 'the execution of a process takes what any of them takes';
is_deeply [sort @{ schema_of(block('parameters', 'output'))->{enum} }], [sort keys %given],
    'every output has its name in the path';

# A cloud is an input, not a parameter.
sub is_cloud { return $_[0]{oneOf} && ($_[0]{oneOf}[0]{contentEncoding} // '') eq 'binary' }

# The schema of a component, in the two ways in which the file writes one: in braces, or as a block with oneOf.
sub schema_of {
    my ($text) = @_;
    my ($line, $members) = $text =~ /^      schema:(.*)\n((?:        .*\n)*)/m or return {};
    return flow($line) if $line =~ /\S/;
    my %schema = $members =~ /^        (\w+): (\S.*)$/mg;
    $_ = flow($_) for values %schema;
    $schema{oneOf} = [map { flow($_) } $members =~ /^          - (\{.*\})$/mg];
    return \%schema;
}

# A value in YAML's flow style: {a: b}, [a, b] or a word.
sub flow {
    my ($text) = @_;
    my @tokens = $text =~ /[{}\[\],]|\w+:(?= )|"(?:[^"\\]|\\.)*"|[^{}\[\],\s]+/g;
    my $read;
    $read = sub {
        my $token = shift @tokens;
        my ($object, $list) = ($token eq '{', $token eq '[');
        return $token =~ s/^"(.*)"$/$1/r unless $object || $list;
        my (%members, @elements);
        while ((my $next = shift @tokens) !~ /^[}\]]$/) {
            next if $next eq ',';
            if ($object) { $members{ $next =~ s/:$//r } = $read->() }
            else { push @elements, $next }
        }
        return $object ? \%members : \@elements;
    };
    return $read->();
}

# The same with every number written in one way, truth as a word, and without units.
sub plain {
    my ($value) = @_;
    return { map { $_ => plain($value->{$_}) } grep { $_ ne 'x-unit' } keys %$value } if ref $value eq 'HASH';
    return [map { plain($_) } @$value] if ref $value eq 'ARRAY';
    return $value ? 'true' : 'false' if JSON::PP::is_bool($value);
    return $value =~ /^[-+]?[\d.]+(?:e[-+]?\d+)?$/i ? $value + 0 : $value;
}

# The name that a parameter has in a request.
sub name_of { return block('parameters', $_[0]) =~ /^ +name: (\S+)$/m ? $1 : $_[0] }

# The text of a component, and the names of the properties of a schema that lie `indent` deep.
sub block {
    my ($kind, $name) = @_;
    return $yaml =~ /^  $kind:\n(?:(?:    .*)?\n)*?    \Q$name\E:\n((?:(?:      .*)?\n)+)/m ? $1 : '';
}
sub members {
    my ($text, $indent) = @_;
    my $blanks = ' ' x $indent;
    my ($properties) = $text =~ /^ +properties:\n((?:$blanks.*\n)+)/m;
    return [sort(($properties // '') =~ /^$blanks(\w+):/mg)];
}
my $id = $daemon->submit('points=50&iterations=2', sphere_ply(300));
is $daemon->finish($id)->{status}, 'successful', 'a job ends well';
my $record = json($daemon->get("/v1/jobs/$id/trace"))->{records}[0];
is_deeply [sort keys %$record], members(block('schemas', 'record'), 8), 'a record has the members described';
my ($event) = grep { $_->{event} eq 'progress' }
    $daemon->events("/v1/jobs/$id/events", headers => { 'Last-Event-ID' => '1.1' })->all;
is_deeply [sort keys %{ json($event->{data}) }],
    [sort @{ members(block('schemas', 'record'), 8) }, @{ members(block('schemas', 'progressEvent'), 12) }],
    'so has the data of a progress event';
my ($end) = grep { $_->{event} eq 'end' } $daemon->events("/v1/jobs/$id/events")->all;
is_deeply [sort keys %{ json($end->{data}) }], members(block('schemas', 'endEvent'), 8), 'so has that of the end';
my @outputs = sort keys %{ json($daemon->get('/v1/processes/resample'))->{outputs} };
is_deeply [sort keys %{ json($end->{data})->{outputs} }], \@outputs, 'which has the outputs of the process';
my $results = json($daemon->get("/v1/jobs/$id/results"));
is_deeply [sort keys %$results], \@outputs, 'and so have the results';
is_deeply [sort keys %{ $results->{$_} }], members(block('schemas', 'results'), 10), "$_ with the members described"
    for @outputs;
my $report = json($daemon->get("/v1/jobs/$id/results/report"));
my $described = block('schemas', 'report');
is_deeply [sort keys %$report], members($described, 8), 'so has a report';

# The tables of the report and the record, as a process describes them, against the schemas here.
my $process = json($daemon->get('/v1/processes/resample'));
for my $case (['report', $process->{outputs}{report}{schema}, $report], ['record', $process->{'x-record'}, $record]) {
    my ($name, $table, $told) = @$case;
    my $schema = read_schema(block('schemas', $name));
    cmp_ok scalar keys %{ $schema->{properties} }, '>', 10, "the schema of a $name can be read";
    is_deeply $schema, bare($table), "the schema of a $name is that of its table";
    is_deeply [undescribed($told, $table, $name)], [], "a $name has those members and no others";
}

# What of a schema both must say: type, words, names; all of them are required.
sub bare {
    my ($schema) = @_;
    my %bare = map { $_ => $schema->{$_} } grep { defined $schema->{$_} } qw(type enum);
    if (my $properties = $schema->{properties}) {
        $bare{properties} = { map { $_ => bare($properties->{$_}) } keys %$properties };
        $bare{required} = [sort @{ $schema->{required} }];
    }
    $bare{items} = bare($schema->{items}) if $schema->{items};
    return \%bare;
}

# The keys of a block mapping, each with what stands behind it.
sub parts {
    my ($text) = @_;
    my ($blanks) = $text =~ /^( *)/;
    my %part;
    while ($text =~ /^$blanks([\w-]+):(.*\n(?:(?:$blanks +.*)?\n)*)/mg) { $part{$1} = $2 }
    s/^\n// for values %part;
    return %part;
}

# The same from the YAML of a schema: its lines in one block, or braces in one line.
sub read_schema {
    my ($text) = @_;
    my %schema;
    if ($text =~ /^\s*\{(.*)\}\s*$/) {
        my $inside = $1;
        $schema{type} = $1 if $inside =~ /\btype: (\w+)/;
        $schema{enum} = [split /, /, $1] if $inside =~ /\benum: \[([^\]]*)\]/;
        return \%schema;
    }
    my %part = parts($text);
    $schema{type} = $1 if ($part{type} // '') =~ /(\w+)/;
    $schema{enum} = [split /, /, $1] if ($part{enum} // '') =~ /\[([^\]]*)\]/;
    $schema{required} = [sort split /,\s*/, $1] if ($part{required} // '') =~ /\[([^\]]*)\]/;
    $schema{items} = read_schema($part{items}) if $part{items};
    my %property = parts($part{properties} // '');
    $schema{properties} = { map { $_ => read_schema($property{$_}) } keys %property } if %property;
    return \%schema;
}

# Where a value and its schema do not have the same members.
sub undescribed {
    my ($value, $schema, $at) = @_;
    if (ref $value eq 'ARRAY') { return map { undescribed($_, $schema->{items}, "$at\[]") } @$value }
    return () unless ref $value eq 'HASH' && $schema->{properties};
    my %names = map { $_ => 1 } keys %$value, keys %{ $schema->{properties} };
    return map {
        exists $value->{$_} && $schema->{properties}{$_}
            ? undescribed($value->{$_}, $schema->{properties}{$_}, "$at.$_") : "$at.$_"
    } sort keys %names;
}
SKIP: {
    skip 'python3 with yaml is not installed', 1
        if system('python3 -c "import yaml" 2>/dev/null') != 0;
    is system('python3', '-c', 'import sys, yaml; yaml.safe_load(open(sys.argv[1]))',
        "$FindBin::Bin/../../openapi.yaml"), 0, 'it is YAML';
}
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
