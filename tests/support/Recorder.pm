# A recorder between HTTP/1.1 clients and a daemon: passes every byte on as it comes, and tells afterwards what was
# asked and what was answered.
package Recorder;
use strict;
use warnings;
use File::Temp qw(tempdir);
use IO::Select;
use IO::Socket::INET;
use POSIX ();
use Time::HiRes qw(sleep time);

my ($owner, %running) = ($$);
END {
    local $?;
    if ($$ == $owner) { kill 'KILL', -$_ for keys %running }
}

# Listens on `port`, or a free one where another program has it: its {address}. `to` is the HOST:PORT of a daemon, which need not
# be there yet.
sub start {
    my ($class, $to, $port) = @_;
    my $self = bless { to => $to, dir => tempdir(CLEANUP => 1) }, $class;
    my ($listener) = grep { $_ } map { IO::Socket::INET->new(LocalAddr => "127.0.0.1:$_", Listen => 64, ReuseAddr => 1) } $port // 0, 0;

    die "recorder: $!" unless $listener;

    $self->{address} = '127.0.0.1:' . $listener->sockport;
    $self->{pid} = fork // die "fork: $!";
    if ($self->{pid} == 0) {
        setpgrp;
        eval { $self->serve($listener) };
        POSIX::_exit(0);
    }
    $running{ $self->{pid} } = 1;
    return $self;
}

# Ends it, and what it still passes on.
sub stop {
    my ($self) = @_;
    my $pid = delete $self->{pid} // return;
    kill 'KILL', -$pid, $pid;
    waitpid $pid, 0;
    delete $running{$pid};
}

# A process for each connection.
sub serve {
    my ($self, $listener) = @_;
    local $SIG{CHLD} = 'IGNORE';
    local $SIG{PIPE} = 'IGNORE';
    for (my $n = 1; ; $n++) {
        my $client = $listener->accept // next;
        next if fork;
        close $listener;
        $self->relay($client, sprintf '%s/%04d', $self->{dir}, $n);
        POSIX::_exit(0);
    }
}

# Both ways until both ends are done, or one is gone.
sub relay {
    my ($self, $client, $name) = @_;
    my $daemon = $self->reach // return;
    my %way = (
        $client => { to => $daemon, log => written("$name.asked") },
        $daemon => { to => $client, log => written("$name.told") },
    );
    my $open = IO::Select->new($client, $daemon);
    while ($open->count) {
        for my $from ($open->can_read) {
            my $way = $way{$from};
            if ($from->sysread(my $bytes, 65536)) {
                return unless pass($way->{log}, $bytes) && pass($way->{to}, $bytes);
            } else {
                $open->remove($from);
                $way->{to}->shutdown(1);
            }
        }
    }
}

sub written {
    my ($path) = @_;
    open my $file, '>:raw', $path or die "$path: $!";
    return $file;
}

# Writes all of it; false when the other end is gone.
sub pass {
    my ($to, $bytes) = @_;
    for (my $at = 0; $at < length $bytes;) {
        $at += syswrite($to, $bytes, length($bytes) - $at, $at) // return 0;
    }
    return 1;
}

# A connection to the daemon, which may be on its way.
sub reach {
    my ($self) = @_;
    my $until = time + 20;
    while (time < $until) {
        my $daemon = IO::Socket::INET->new(PeerAddr => $self->{to});
        return $daemon if $daemon;
        sleep 0.05;
    }
    return undef;
}

# What was asked and answered, in the order of connections: { method, target, asked (headers), status, headers, body }.
sub exchanges {
    my ($self) = @_;
    my @exchanges;
    for my $path (sort glob "$self->{dir}/*.asked") {
        my @asked = messages(slurp($path));
        my @told = messages(slurp($path =~ s/asked$/told/r), map { $_->{line} } @asked);
        for my $i (0 .. $#asked) {
            my ($method, $target) = $asked[$i]{line} =~ /^(\S+) (\S+)/;
            my ($status) = ($told[$i]{line} // '') =~ m{^HTTP/1\.1 (\d+)};
            push @exchanges, { method => $method, target => $target, asked => $asked[$i]{headers}, status => $status,
                headers => $told[$i]{headers}, body => $told[$i]{body} };
        }
    }
    return @exchanges;
}

sub slurp {
    my ($path) = @_;
    open my $file, '<:raw', $path or return '';
    local $/;
    return scalar <$file> // '';
}

# The messages that stand one behind the other: { line, headers, body }. An answer of 1xx is none. Answers need the
# lines of their requests, as one to HEAD tells a length without a body.
sub messages {
    my ($bytes, @requests) = @_;
    my @messages;
    while ($bytes =~ s/\A(\S[^\r\n]*)\r\n((?:[^\r\n]+\r\n)*)\r\n//) {
        my ($line, $head) = ($1, $2);
        my %headers = map { /^([^:]+):\s*(.*)$/ ? (lc $1, $2) : () } split /\r\n/, $head;
        next if $line =~ m{^HTTP/1\.1 1\d\d};
        my $is_empty = $line =~ m{^HTTP/1\.1 } ? $line =~ m{^\S+ (?:204|304)} || (shift @requests // '') =~ /^HEAD /
            : !defined($headers{'content-length'} // $headers{'transfer-encoding'});
        push @messages, { line => $line, headers => \%headers, body => $is_empty ? '' : body(\$bytes, \%headers) };
    }
    return @messages;
}

# Takes a body off the bytes: by its chunks, by its length, or all there is.
sub body {
    my ($bytes, $headers) = @_;
    my $length = $headers->{'content-length'};
    my $body = '';
    if (($headers->{'transfer-encoding'} // '') ne 'chunked') {
        return substr $$bytes, 0, $length // length $$bytes, '';
    }
    while ($$bytes =~ s/\A([0-9a-fA-F]+)\r\n//) {
        my $size = hex $1;
        $body .= substr $$bytes, 0, $size, '';
        $$bytes =~ s/\A\r\n//;
        last if $size == 0;
    }
    return $body;
}

1;
